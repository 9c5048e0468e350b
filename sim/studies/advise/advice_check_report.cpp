#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/report/plot.hpp"
#include "sim/studies/advise/advice_check.hpp"

namespace feltwire::advise {
namespace {

using Cases = std::vector<CheckedCase>;

/// A prediction, and its pairs in a case.
struct Kind {
  const char* name;
  std::function<std::vector<Compared>(const CheckedCase&)> pairs;
};

std::vector<Kind> kinds() {
  const auto one = [](Compared CheckedCase::*member) {
    return [member](const CheckedCase& c) { return std::vector<Compared>{c.*member}; };
  };
  return {{"displayed stiffness", [](const CheckedCase& c) { return c.felt; }},
          {"age of the news", one(&CheckedCase::news_age)},
          {"bandwidth up", one(&CheckedCase::up)},
          {"bandwidth down", one(&CheckedCase::down)},
          {"CPU of the server", one(&CheckedCase::server)},
          {"CPU of the client", one(&CheckedCase::client)}};
}

struct Errors {
  std::vector<double> all;
  std::size_t in_band = 0;
};

Errors errors_of(const Cases& cases, bool judged, const Kind& kind) {
  Errors errors;
  for (const CheckedCase& c : cases) {
    if (c.judged != judged) continue;
    for (const Compared& pair : kind.pairs(c)) {
      errors.all.push_back(pair.error());
      errors.in_band += pair.in_band ? 1 : 0;
    }
  }
  return errors;
}

void append_half(std::string& text, const Cases& cases, bool judged) {
  append(text, "%s\n%-22s %7s %9s %9s %9s\n", judged ? "\nThe judged half" : "The half for tuning",
         "prediction", "pairs", "median", "worst", "in band");
  for (const Kind& kind : kinds()) {
    const Errors errors = errors_of(cases, judged, kind);
    if (errors.all.empty()) continue;
    append(text, "%-22s %7zu %7.1f %% %7.1f %% %9zu\n", kind.name, errors.all.size(),
           kPercent * median(errors.all), kPercent * *std::ranges::max_element(errors.all),
           errors.in_band);
  }
  std::size_t hands = 0, foretold = 0, calm = 0;
  for (const CheckedCase& c : cases) {
    if (c.judged != judged) continue;
    for (const Compared& pair : c.calm) {
      ++hands;
      foretold += pair.in_band ? 1 : 0;
      calm += pair.measured < 10e-6 ? 1 : 0;
    }
  }
  append(text, "calm or not: foretold for %zu of %zu presses (%zu are calm)\n", foretold, hands,
         calm);
}

std::string text_of(const Setting& s) {
  std::string text = s.mode_option();
  append(text, " %.0f Hz, %s%s", s.rate, s.traffic_option().c_str(),
         s.local_model ? "" : ", no model");
  return text;
}

nlohmann::ordered_json json_of(const CheckedCase& c) {
  const auto pair = [](const Compared& p) {
    return nlohmann::ordered_json{
        {"predicted", p.predicted}, {"measured", p.measured}, {"in_band", p.in_band}};
  };
  nlohmann::ordered_json json{{"seed", c.seed},
                              {"judged", c.judged},
                              {"setting", text_of(c.setting)},
                              {"passive", c.passive},
                              {"score", c.score}};
  for (const Kind& kind : kinds())
    for (const Compared& p : kind.pairs(c)) json[kind.name].push_back(pair(p));
  for (const Compared& p : c.calm) json["oscillation"].push_back(pair(p));
  if (c.best >= 0.0) {
    json["best"] = c.best;
    json["best_setting"] = text_of(c.best_setting);
  }
  return json;
}

}  // namespace

std::string check_table(const std::vector<CheckedCase>& cases) {
  std::string text;
  append_half(text, cases, false);
  append_half(text, cases, true);
  text += "\nThe advice against the best of a search over " +
          std::to_string(all_settings().size()) + " settings\n";
  append(text, "%-10s %7s %7s %7s  %-44s %s\n", "seed", "advice", "best", "ratio", "advised",
         "best setting");
  std::size_t searched = 0, near = 0, passive = 0;
  for (const CheckedCase& c : cases) {
    passive += c.passive ? 1 : 0;
    if (c.best < 0.0) continue;
    const double ratio = c.best > 0.0 ? c.score / c.best : 1.0;
    constexpr double kNear = 0.9;
    ++searched;
    near += ratio >= kNear ? 1 : 0;
    append(text, "%-10llu %7.3f %7.3f %7.3f  %-44s %s\n", static_cast<unsigned long long>(c.seed),
           c.score, c.best, ratio, text_of(c.setting).c_str(), text_of(c.best_setting).c_str());
  }
  append(text, "within 10 %% of the best: %zu of %zu; passive: %zu of %zu cases\n", near, searched,
         passive, cases.size());
  return text;
}

void write_check(const std::filesystem::path& directory, const std::vector<CheckedCase>& cases) {
  std::filesystem::create_directories(directory);
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  std::string csv = "seed,half,prediction,predicted,measured,error,in_band\n";
  std::string script =
      "set terminal pngcairo size 1000,700 font 'Sans,11'\nset output 'advise_check.png'\n"
      "set logscale xy\nset grid lt 1 lc rgb '#dddddd'\nset tics nomirror\nset key bottom right\n"
      "set xlabel 'measured stiffness at the handle [N/m]'\n"
      "set ylabel 'predicted [N/m]'\n$tuning << END\n";
  std::string judged = "$judged << END\n";
  for (const CheckedCase& c : cases) {
    all.push_back(json_of(c));
    for (const Kind& kind : kinds())
      for (const Compared& p : kind.pairs(c))
        append(csv, "%llu,%s,%s,%.6g,%.6g,%.4g,%d\n", static_cast<unsigned long long>(c.seed),
               c.judged ? "judged" : "tuning", kind.name, p.predicted, p.measured, p.error(),
               p.in_band ? 1 : 0);
    for (const Compared& p : c.felt)
      append(c.judged ? judged : script, "%.6g %.6g\n", p.measured, p.predicted);
  }
  script += "END\n" + judged +
            "END\nplot x with lines lc rgb '#999999' title 'predicted as measured', "
            "$tuning with points pt 6 lc rgb '#0072b2' title 'for tuning', "
            "$judged with points pt 7 lc rgb '#d55e00' title 'judged'\n";
  write_text(directory / "advise_check.json", all.dump(2) + "\n");
  write_text(directory / "advise_check.csv", csv);
  plot(directory, "advise_check", script);
}

}  // namespace feltwire::advise
