#include "client/hands/plant_file.hpp"

#include <stdexcept>

#include "client/hands/plant_generated.h"
#include "client/hands/plant_text.hpp"
#include "core/base/json_document.hpp"

namespace feltwire {
namespace {

void require(const JsonDocument& document, const char* field, const char* says) {
  if (!document.has(field)) document.fail(field, says);
}

Plant::Amplifier read(const plant_file::Amplifier& given) {
  return {.lag = given.lag(),
          .delay = given.delay(),
          .jitter = given.jitter(),
          .resolution = given.resolution()};
}

Plant::Transmission read(const plant_file::Transmission& given, const JsonDocument& document) {
  require(document, "transmission.stiffness",
          "is missing; give it [N/m], or leave the transmission out for a rigid one");
  require(document, "transmission.handle_mass",
          "is missing; give the part of the device's apparent mass that is behind the "
          "transmission [kg]");
  return {.stiffness = given.stiffness(),
          .damping = given.damping(),
          .backlash = given.backlash(),
          .handle_mass = given.handle_mass()};
}

Plant::Friction read(const plant_file::Friction& given, const JsonDocument& document) {
  require(document, "friction.breakaway",
          "is missing; give the dry friction at rest [N], or leave friction out");
  return {.breakaway = given.breakaway(), .stribeck_velocity = given.stribeck_velocity()};
}

Plant::Encoder read(const plant_file::Encoder& given, const JsonDocument& document) {
  Plant::Encoder encoder{.noise = given.noise()};
  if (given.side() == nullptr) return encoder;
  encoder.side =
      document.choice<EncoderSide>("encoder.side", given.side()->string_view(), kEncoderSideNames);
  return encoder;
}

Plant::HeldHand read(const plant_file::Hand& given, const JsonDocument& document) {
  Plant::HeldHand hand{.reflex_delay = given.reflex_delay(),
                       .reflex_stiffness = given.reflex_stiffness(),
                       .reflex_damping = given.reflex_damping()};
  if (document.has("hand.mass")) hand.mass = given.mass();
  if (document.has("hand.damping")) hand.damping = given.damping();
  if (document.has("hand.stiffness")) hand.stiffness = given.stiffness();
  if (document.has("hand.pad_stiffness")) hand.pad_stiffness = given.pad_stiffness();
  hand.pad_damping = given.pad_damping();
  if (given.grip() != nullptr)
    for (const auto* grip : *given.grip()) hand.grip.push_back({grip->time(), grip->share()});
  return hand;
}

Plant read_plant(std::string_view text, std::string file) {
  const JsonDocument document(text, std::move(file), embedded::plant);
  const auto& given = *plant_file::GetPlant(document.buffer());
  Plant plant;
  if (given.name() != nullptr) plant.name = given.name()->str();
  plant.seed = given.seed();
  if (given.amplifier() != nullptr) plant.amplifier = read(*given.amplifier());
  if (given.transmission() != nullptr) plant.transmission = read(*given.transmission(), document);
  if (given.friction() != nullptr) plant.friction = read(*given.friction(), document);
  if (given.encoder() != nullptr) plant.encoder = read(*given.encoder(), document);
  if (given.hand() != nullptr) plant.hand = read(*given.hand(), document);
  if (given.friction() != nullptr && !(plant.friction.breakaway > 0.0))
    document.fail("friction.breakaway",
                  "must be above 0 N; leave friction out for the device's dry friction alone");
  try {
    validate(plant);
  } catch (const PlantError& error) {
    document.fail(error.field, error.why);
  }
  return plant;
}

}  // namespace

Plant load_plant(const std::filesystem::path& file) {
  return read_plant(read_text(file), file.string());
}

std::string plant_file_of(std::string_view name) {
  constexpr std::string_view kKey = "plant=";
  if (name.starts_with(kKey) && name.size() > kKey.size())
    return std::string(name.substr(kKey.size()));
  throw std::invalid_argument("--device simulated:" + std::string(name) +
                              ": write it as simulated or simulated:plant=FILE.json");
}

}  // namespace feltwire
