#include "sim/studies/advise/advice_report.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "core/base/visible_text.hpp"
#include "sim/report/plot.hpp"

namespace feltwire::advise {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMega = 1e-6;    // megabytes of a byte
constexpr std::size_t kRoom = 1;  // sessions beside the hands that were asked for: an observer

void append_felt(std::string& text, const Felt& felt) {
  append(text, "  wall %7.0f N/m   felt %7.0f (%.0f to %.0f) N/m   %s", felt.wall, felt.felt,
         felt.low, felt.high, felt.calm() ? "calm" : "A HAND SWINGS");
  if (felt.limit != Limit::nothing)
    append(text, "   limited by %s", std::string(name(felt.limit)).c_str());
  text += '\n';
  constexpr std::size_t kShown = 3;
  for (std::size_t i = 0; i < felt.purchases.size() && i < kShown; ++i)
    append(text, "      %s would give %.0f N/m\n", felt.purchases[i].what.c_str(),
           felt.purchases[i].felt);
}

void append_value(std::string& text, const char* what, const Predicted& p, double unit,
                  const char* unit_text) {
  append(text, "  %-24s %8.3g %s (%.3g to %.3g)\n", what, unit * p.value, unit_text, unit * p.low,
         unit * p.high);
}

Json json_of(const Predicted& p) { return {{"value", p.value}, {"low", p.low}, {"high", p.high}}; }

Json json_of(const Felt& felt) {
  Json buying = Json::array();
  for (const Purchase& one : felt.purchases)
    buying.push_back({{"limit", name(one.limit)}, {"what", one.what}, {"felt_n_per_m", one.felt}});
  return {{"wall_n_per_m", felt.wall},
          {"felt_n_per_m", felt.felt},
          {"low", felt.low},
          {"high", felt.high},
          {"swing_m", felt.swing},
          {"calm", felt.calm()},
          {"limited_by", name(felt.limit)},
          {"buying", buying}};
}

bool is_file(const std::string& device) { return device.ends_with(".json"); }

std::string whole_path(const std::filesystem::path& path) {
  return std::filesystem::absolute(path).lexically_normal().string();
}

/// Draws the stiffness of each material, and what is felt of it.
void draw(const std::filesystem::path& directory, const Advice& advice) {
  std::string script =
      "set terminal pngcairo size 900,520 font 'Sans,11'\nset output 'advice.png'\n"
      "set style fill solid 0.8\nset boxwidth 0.35\nset logscale y\nset grid ytics lt 1 lc rgb "
      "'#dddddd'\nset tics nomirror\nset ylabel 'stiffness [N/m]'\nset xlabel 'material'\n"
      "set title 'The walls of the scene, and what a hand feels of them'\n$felt << END\n";
  double least = 1e9, most = 1.0;
  for (std::size_t i = 0; i < advice.feel.size(); ++i) {
    const Felt& felt = advice.feel[i];
    append(script, "%zu %.6g %.6g %.6g %.6g\n", i + 1, felt.wall, felt.felt, felt.low, felt.high);
    least = std::min({least, felt.wall, std::max(0.1, felt.low)});
    most = std::max(most, felt.wall);
  }
  append(script, "END\nset xrange [0.3:%.1f]\nset yrange [%.6g:%.6g]\nset xtics 1\n",
         static_cast<double>(advice.feel.size()) + 0.7, 0.5 * least, 2.0 * most);
  script +=
      "plot $felt using ($1-0.18):2 with boxes lc rgb '#999999' title 'the scene', "
      "$felt using ($1+0.18):3 with boxes lc rgb '#0072b2' title 'felt', "
      "$felt using ($1+0.18):3:4:5 with yerrorbars lc rgb '#000000' title 'band'\n";
  plot(directory, "advice", script);
}

}  // namespace

std::string advice_text(const Question& question, const Sources& sources, const Advice& advice) {
  std::string text;
  append(text, "device %s, link %s, scene %s, %d hand(s), %d core(s)\n\nSet\n",
         visible(sources.device).c_str(), visible(question.link.text).c_str(),
         visible(sources.scene.filename().string()).c_str(), question.hands, question.cores);
  append(text, "  feltwire-client --mode %s --rate %.0f --traffic %s --local-model %s\n",
         advice.setting.mode_option().c_str(), advice.setting.rate,
         advice.setting.traffic_option().c_str(), advice.setting.local_model ? "whole" : "off");
  for (const std::string& reason : advice.reasons) text += "  - " + visible(reason) + '\n';
  for (const std::string& line : advice.scene) text += "  - " + visible(line) + '\n';
  text += "\nA first press will feel, at the handle\n";
  for (const Felt& felt : advice.feel) append_felt(text, felt);
  text += "\nA hand gets\n";
  append_value(text, "oscillation at rest", advice.oscillation, kMicro, "um RMS");
  append_value(text, "force later than the hand", advice.force_delay, kMilli, "ms");
  append_value(text, "age of the news", advice.news_age, kMilli, "ms");
  append(text, "      of it %.3g ms the link, %.3g ms added\n", kMilli * advice.link_delay,
         kMilli * (advice.news_age.value - advice.link_delay));
  append_value(text, "up", advice.up, 1.0, "kbit/s");
  append_value(text, "down", advice.down, 1.0, "kbit/s");
  append_value(text, "client's computing", advice.client, kPercent, "% of a core");
  append_value(text, "client's memory", advice.client_memory, kMega, "MB");
  text += "\nThe server needs\n";
  append_value(text, "computing for a hand", advice.server, kPercent, "% of a core");
  append(text, "      and %.3g %% for its datagrams in the kernel, where the core is full\n",
         kPercent * advice.cost.kernel);
  append_value(text, "hands a core", advice.hands_a_core, 1.0, "");
  append(text, "      %d core(s) for %d hand(s)\n", advice.cores_needed, question.hands);
  append_value(text, "memory", advice.server_memory, kMega, "MB");
  append_value(text, "memory of a hand", advice.session_memory, 1e-3, "kB");
  append(text, "\nBeside the walls, the session is limited by %s\n",
         std::string(name(advice.limit)).c_str());
  for (const std::string& remedy : advice.remedies) text += "  - " + visible(remedy) + '\n';
  return text;
}

std::string advice_json(const Question& question, const Sources& sources, const Advice& advice) {
  Json feel = Json::array();
  for (const Felt& felt : advice.feel) feel.push_back(json_of(felt));
  const Setting& s = advice.setting;
  Json json{{"device", sources.device},
            {"link", question.link.text},
            {"scene", sources.scene.string()},
            {"hands", question.hands},
            {"cores", question.cores},
            {"setting",
             {{"mode", s.mode_option()},
              {"side", "client"},
              {"rate_hz", s.rate},
              {"traffic", s.traffic_option()},
              {"local_model", s.local_model ? "whole" : "off"}}},
            {"reasons", advice.reasons},
            {"scene_advice", advice.scene},
            {"feel", feel},
            {"oscillation_m", json_of(advice.oscillation)},
            {"force_delay_s", json_of(advice.force_delay)},
            {"news_age_s", json_of(advice.news_age)},
            {"link_delay_s", advice.link_delay},
            {"up_kbit_per_s", json_of(advice.up)},
            {"down_kbit_per_s", json_of(advice.down)},
            {"server_cpu", json_of(advice.server)},
            {"server_kernel_cpu", advice.cost.kernel},
            {"client_cpu", json_of(advice.client)},
            {"hands_a_core", json_of(advice.hands_a_core)},
            {"cores_needed", advice.cores_needed},
            {"server_memory_bytes", json_of(advice.server_memory)},
            {"session_memory_bytes", json_of(advice.session_memory)},
            {"client_memory_bytes", json_of(advice.client_memory)},
            {"command_left", advice.fade},
            {"limited_by", name(advice.limit)},
            {"remedies", advice.remedies}};
  return json.dump(2) + "\n";
}

std::string client_config(const Sources& sources, const Advice& advice) {
  const Setting& s = advice.setting;
  const Json json{{"spec", is_file(sources.device) ? whole_path(sources.device) : sources.device},
                  {"mode", s.mode_option()},
                  {"rate", s.rate},
                  {"traffic", s.traffic_option()},
                  {"local_model", s.local_model ? "whole" : "off"}};
  return json.dump(2) + "\n";
}

std::string server_config(const Question& question, const Sources& sources, const Advice& advice) {
  constexpr std::size_t kMostSessions = 4096;
  Json json{{"scenes", Json::array({whole_path(sources.scene)})}};
  // A line that is full of datagrams is the reason for a profile at the server.
  if (advice.setting.profile == "thin") json["profile"] = "thin";
  json["max_sessions_per_scene"] =
      std::min(kMostSessions, static_cast<std::size_t>(question.hands) + kRoom);
  return json.dump(2) + "\n";
}

void write_advice(const std::filesystem::path& directory, const Question& question,
                  const Sources& sources, const Advice& advice) {
  std::filesystem::create_directories(directory);
  write_text(directory / "advice.txt", advice_text(question, sources, advice));
  write_text(directory / "advice.json", advice_json(question, sources, advice));
  write_text(directory / "client.json", client_config(sources, advice));
  write_text(directory / "server.json", server_config(question, sources, advice));
  draw(directory, advice);
}

}  // namespace feltwire::advise
