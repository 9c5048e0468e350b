#include "sim/studies/extremes/extreme_matrix.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/base/text.hpp"

namespace feltwire {
namespace {

constexpr int kStressWidth = 30, kCellWidth = 9;  // [characters]

/// Adds a name that is not in the list yet.
void add_name(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

const ExtremeCell* find_cell(const ExtremeMatrix& matrix, const std::string& stress,
                             const std::string& judged) {
  const auto found = std::find_if(
      matrix.cells.begin(), matrix.cells.end(),
      [&](const ExtremeCell& cell) { return cell.stress == stress && cell.judged == judged; });
  return found == matrix.cells.end() ? nullptr : &*found;
}

std::string cell_text(const ExtremeCell& cell) {
  if (!cell.passed()) return "FAILED";
  if (!cell.refused.empty()) return "refused";
  if (!cell.kept()) return "warned";
  std::string text;
  if (cell.error > 0.0)
    append(text, "%.0e", cell.error);
  else
    text = "0";
  return text;
}

std::string failure_text(const ExtremeCell& cell) {
  std::string text;
  append(text, "FAILED  %s, %s: ", cell.stress.c_str(), cell.judged.c_str());
  if (!cell.refused.empty()) return text + "refused without a field: " + cell.refused + "\n";
  append(text, "%llu checks, %llu NaN or Inf, %llu over the limit, %llu holes; error %.2e of %.1e ",
         static_cast<unsigned long long>(cell.checks),
         static_cast<unsigned long long>(cell.not_finite),
         static_cast<unsigned long long>(cell.over_limit),
         static_cast<unsigned long long>(cell.holes), cell.error, cell.allowed);
  return text + "(" + cell.reference + ")\n";
}

/// Returns the text with its double quotes doubled, as a CSV field.
std::string quoted(const std::string& text) {
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + '"';
}

}  // namespace

void ExtremeCell::judge(bool finite, double found_error, bool within_limit) {
  ++checks;
  over_limit += within_limit ? 0 : 1;
  if (!finite || !std::isfinite(found_error))
    ++not_finite;
  else
    error = std::max(error, found_error);
}

bool ExtremeMatrix::passed() const {
  return !cells.empty() &&
         std::all_of(cells.begin(), cells.end(), [](const ExtremeCell& c) { return c.passed(); });
}

std::string stress_name(const char* quantity, double value, const char* unit) {
  std::string text;
  append(text, "%s %g%s%s", quantity, value, *unit == '\0' ? "" : " ", unit);
  return text;
}

std::string extreme_matrix_table(const ExtremeMatrix& matrix) {
  std::vector<std::string> stresses, columns;
  for (const ExtremeCell& cell : matrix.cells) {
    add_name(stresses, cell.stress);
    add_name(columns, cell.judged);
  }
  std::string text = matrix.part + ": " + matrix.title + "\n";
  append(text, "%-*s", kStressWidth, "");
  for (const std::string& column : columns) append(text, " %*s", kCellWidth, column.c_str());
  text += '\n';
  for (const std::string& stress : stresses) {
    append(text, "%-*s", kStressWidth, stress.c_str());
    for (const std::string& column : columns) {
      const ExtremeCell* cell = find_cell(matrix, stress, column);
      append(text, " %*s", kCellWidth, cell == nullptr ? "" : cell_text(*cell).c_str());
    }
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  }
  std::vector<std::string> notes;
  for (const ExtremeCell& cell : matrix.cells) {
    if (!cell.refused.empty()) add_name(notes, "refused  " + cell.stress + ": " + cell.refused);
    if (!cell.kept() && !cell.warned.empty())
      add_name(notes, "warned  " + cell.stress + ": " + cell.warned);
  }
  for (const std::string& note : notes) text += note + "\n";
  for (const ExtremeCell& cell : matrix.cells)
    if (!cell.passed()) text += failure_text(cell);
  return text;
}

void write_extreme_matrix(const std::filesystem::path& directory, const ExtremeMatrix& matrix) {
  std::filesystem::create_directories(directory);
  std::string csv =
      "stress,judged,reference,checks,not_finite,over_limit,holes,error,allowed,passed,refused,"
      "warned\n";
  auto document = nlohmann::ordered_json::array();
  for (const ExtremeCell& cell : matrix.cells) {
    csv += quoted(cell.stress) + ',' + quoted(cell.judged) + ',' + quoted(cell.reference);
    append(csv, ",%llu,%llu,%llu,%llu,%.3g,%.3g,%d,", static_cast<unsigned long long>(cell.checks),
           static_cast<unsigned long long>(cell.not_finite),
           static_cast<unsigned long long>(cell.over_limit),
           static_cast<unsigned long long>(cell.holes), cell.error, cell.allowed, cell.passed());
    csv += quoted(cell.refused) + ',' + quoted(cell.warned) + '\n';
    document.push_back({{"stress", cell.stress},
                        {"judged", cell.judged},
                        {"reference", cell.reference},
                        {"checks", cell.checks},
                        {"not_finite", cell.not_finite},
                        {"over_limit", cell.over_limit},
                        {"holes", cell.holes},
                        {"error", cell.error},
                        {"allowed", cell.allowed},
                        {"passed", cell.passed()},
                        {"refused", cell.refused},
                        {"warned", cell.warned}});
  }
  write_text(directory / ("extremes_" + matrix.part + ".csv"), csv);
  write_text(directory / ("extremes_" + matrix.part + ".json"), document.dump(1) + '\n');
}

}  // namespace feltwire
