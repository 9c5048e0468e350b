#include "server/web/viewer_message.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "protocol/session/material_fields.hpp"

namespace feltwire::web {
namespace {

constexpr std::array<std::pair<std::string_view, double LinkQuality::*>, 3> kLinkFields = {
    {{"link_delay", &LinkQuality::delay},
     {"link_jitter", &LinkQuality::jitter},
     {"link_loss", &LinkQuality::loss}}};

/// Stores the members of the outermost JSON object, and of its member `set`, while the text is
/// parsed. It builds no JSON tree, because the destructor of a tree allocates memory, and ends the
/// program if there is none.
class Members : public nlohmann::json_sax<nlohmann::json> {
 public:
  ViewerMessage message;

  bool null() override { return value(); }
  bool boolean(bool given) override {
    if (depth_ == 1 && key_ == "reload") message.reload = given;
    if (depth_ == 1 && key_ == "record") message.record = given;
    return value() && !in_set();
  }
  bool number_integer(number_integer_t given) override {
    return number(static_cast<double>(given));
  }
  bool number_unsigned(number_unsigned_t given) override {
    return number(static_cast<double>(given));
  }
  bool number_float(number_float_t given, const string_t&) override { return number(given); }
  bool binary(binary_t&) override { return false; }
  bool string(string_t& text) override {
    if (depth_ == 1 && key_ == "token") message.token = text;
    if (depth_ == 1 && key_ == "watch") message.watch = text;
    if (depth_ == 1 && key_ == "ticket") message.ticket = text;
    if (depth_ == 1 && key_ == "hand") message.hand = text;
    if (depth_ == 1 && key_ == "mode") message.mode = text;
    if (depth_ == 1 && key_ == "admin") message.admin = text;
    if (depth_ == 1 && key_ == "evict") message.evict = text;
    if (depth_ == 1 && key_ == "recording") message.recording = text;
    if (depth_ == 1 && key_ == "download") message.download = text;
    return value() && (!in_set() || set_text(text));
  }
  bool key(string_t& text) override {
    if (depth_ == 1) key_ = text;
    if (in_set()) member_ = text;
    return true;
  }
  bool start_object(std::size_t) override {
    if (in_set()) return false;
    if (depth_ == 1 && key_ == "set") message.set.emplace();
    return enter();
  }
  bool end_object() override { return leave(); }
  bool start_array(std::size_t) override {
    if (in_set()) {
      if (depth_ != 2 || member_ != "gravity") return false;
      message.set->gravity = Vec3::Zero();
      numbers_ = 0;
    }
    if (depth_ == 1) coordinates_ = 0;
    return value() && enter();
  }
  bool end_array() override {
    if (in_set() && numbers_ != 3) return false;
    leave();
    if (depth_ == 1 && key_ == "point")
      message.point = coordinates_ == 3 ? point_ : Vec3::Constant(std::nan(""));
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception&) override {
    return false;
  }

 private:
  static constexpr int kDeepest = 8;
  bool in_set() const { return depth_ > 1 && key_ == "set"; }
  bool value() const { return depth_ > 0 && !(depth_ == 1 && key_ == "set"); }
  bool enter() { return ++depth_ <= kDeepest; }
  bool leave() {
    --depth_;
    return true;
  }
  bool number(double given) {
    if (!in_set()) return coordinate(given);
    if (depth_ > 2) {  // a component of gravity
      if (numbers_ == 3) return false;
      (*message.set->gravity)[numbers_++] = given;
      return true;
    }
    if (member_ == "lead_share") {
      message.set->lead_share = given;
      return true;
    }
    for (const BoundNumber& entry : kBoundNumbers)
      if (entry.name == member_) {
        message.set->bound.*entry.wanted = given;
        return true;
      }
    for (const auto& [name, field] : kLinkFields)
      if (name == member_) {
        if (!message.set->link) message.set->link.emplace();
        (*message.set->link).*field = given;
        return true;
      }
    for (const MaterialField& field : kMaterialFields)
      if (field.name == member_) {
        message.set->material.*field.wanted = given;
        return true;
      }
    return false;
  }
  bool coordinate(double given) {
    if (depth_ == 2 && coordinates_ < 3) point_[coordinates_] = given;
    if (depth_ == 2) coordinates_ = std::min(coordinates_ + 1, 4);
    return value();
  }
  bool set_text(const std::string& text) {
    ViewerSet& set = *message.set;
    if (depth_ != 2) return false;
    if (member_ == "object")
      set.material.object = text;
    else if (member_ == "session")
      set.session = text;
    else if (member_ == "mode")
      set.bound.mode = text;
    else if (member_ == "projection")
      set.bound.projection = text;
    else if (member_ == "storage")
      set.bound.storage = text;
    else if (member_ == "reference")
      set.bound.reference = text;
    else
      return false;
    return true;
  }

  int depth_ = 0;
  std::string key_, member_;  // current member of the outermost object, and of `set`
  int numbers_ = 0;           // number of components of gravity so far
  Vec3 point_ = Vec3::Zero();
  int coordinates_ = 0;  // number of elements in the array so far; 4: too many
};

}  // namespace

std::optional<ViewerMessage> parse_viewer_message(std::string_view text) {
  Members members;
  if (!nlohmann::json::sax_parse(text, &members)) return std::nullopt;
  return std::move(members.message);
}

}  // namespace feltwire::web
