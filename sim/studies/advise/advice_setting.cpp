#include "sim/studies/advise/advice_setting.hpp"

#include <array>

#include "protocol/session/profiles.hpp"

namespace feltwire::advise {

SessionParameters Setting::parameters() const {
  SessionParameters p = usual_parameters();
  p.mode = law;
  p.storage = storage;
  p.servo_period = 1.0 / rate;
  p = over(network_profile(profile), p);
  p.local_model = local_model;
  if (!force_deadband) p.force_deadband = 0.0;
  validate(p);
  return p;
}

std::string Setting::mode_option() const {
  return law + (storage == Storage::elastic ? ",storage=elastic" : "");
}

std::string Setting::traffic_option() const {
  const bool has_deadband = network_profile(profile).force_deadband > 0.0;
  return profile + (has_deadband && !force_deadband ? ",force_deadband=0" : "");
}

std::vector<Setting> law_choices(double most_rate) {
  constexpr std::array kRates = {1000.0, 2000.0, 4000.0, 500.0};  // [Hz]
  std::vector<Setting> all;
  for (const double rate : kRates) {
    if (rate > most_rate) continue;
    all.push_back({.law = "shaped", .rate = rate});
    all.push_back({.law = "contact_frame", .rate = rate});
    all.push_back({.law = "contact_frame", .storage = Storage::elastic, .rate = rate});
  }
  if (all.empty()) {
    all.push_back({.law = "shaped", .rate = most_rate});
    all.push_back({.law = "contact_frame", .rate = most_rate});
  }
  return all;
}

std::vector<Setting> traffic_choices(const Setting& law, bool moving) {
  std::vector<Setting> all;
  const auto add = [&](const char* profile, bool deadband) {
    Setting setting = law;
    setting.profile = profile;
    setting.force_deadband = deadband;
    all.push_back(setting);
  };
  if (moving) add("lan", true);
  add("wan", true);
  add("wan", false);
  if (!moving) add("lan", true);
  add("thin", true);
  add("thin", false);
  return all;
}

}  // namespace feltwire::advise
