#pragma once
// Compares the advice with whole sessions of drawn cases, and with the best of a search over all
// settings.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/studies/advise/advice.hpp"
#include "sim/studies/advise/measured_session.hpp"

namespace feltwire::advise {

/// A predicted number of a case, and what a session measured.
struct Compared {
  double predicted = 0.0, measured = 0.0;
  bool in_band = false;
  /// |predicted - measured| / measured; 0 where both are 0.
  double error() const;
};

struct CheckedCase {
  std::uint64_t seed = 0;
  bool judged = false;  // false: of the half for tuning
  Setting setting{};
  std::vector<Compared> felt = {};  // [N/m], one for each place
  std::vector<Compared> calm = {};  // predicted and measured oscillation [m]
  Compared news_age{}, up{}, down{}, server{}, client{};
  bool passive = true;
  double score = 0.0;  // mean share that is felt; a hand that swings feels 0
  double best = -1.0;  // of the search; below 0: not searched
  Setting best_setting{};
};

struct CheckOptions {
  std::uint64_t seed = 44'261'130;  // of the first case
  int cases = 60;                   // the first half is for tuning, the second is judged
  int searched = 20;                // judged cases of which all settings are tried
};

/// Runs every case. All but the computing times is deterministic. Throws std::invalid_argument for
/// numbers of cases that are not possible.
std::vector<CheckedCase> check_advice(const CheckOptions& options);

/// The settings of the search.
std::vector<Setting> all_settings();

/// For people: median and worst relative error of each prediction, of both halves; then the advice
/// against the search.
std::string check_table(const std::vector<CheckedCase>& cases);

/// Writes advise_check.csv, .json and .png to `directory` (created). Throws std::runtime_error.
void write_check(const std::filesystem::path& directory, const std::vector<CheckedCase>& cases);

}  // namespace feltwire::advise
