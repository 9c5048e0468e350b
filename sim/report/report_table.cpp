#include "sim/report/report_table.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/base/regular_file.hpp"
#include "core/base/visible_text.hpp"

namespace feltwire {
namespace {

struct Row {
  const char* label;
  const char* pointer;  // JSON pointer into a report
  const char* format;   // printf format of a double
};

constexpr std::array kRows = {
    Row{"position samples", "/samples", "%.0f"},
    Row{"  answered with a force", "/answered", "%.0f"},
    Row{"  datagrams lost", "/lost", "%.0f"},
    Row{"  answered later than 1 ms", "/late", "%.0f"},
    Row{"round trip, median [us]", "/round_trip_us/p50", "%.0f"},
    Row{"round trip, 99 % within [us]", "/round_trip_us/p99", "%.0f"},
    Row{"servo woke up late, median [us]", "/servo_wakeup_late_us/p50", "%.0f"},
    Row{"largest force on the hand [N]", "/max_force_n", "%.2f"},
    Row{"oscillation in contact, RMS [um]", "/oscillation_um", "%.1f"},
    Row{"displayed stiffness [N/m]", "/displayed_stiffness_n_per_m", "%.0f"},
    Row{"force off its commanded direction, mean [deg]", "/direction_error_deg/mean", "%.3f"},
    Row{"energy to the hand by contact [J] *", "/energy_delivered_j/elastic", "%.4f"},
    Row{"energy to the hand by friction [J] *", "/energy_delivered_j/frictional", "%.4f"},
    Row{"times the energy bound was broken", "/bound_violations", "%.0f"},
};

/// Returns the width of a text in a terminal: the number of its characters. Continuation bytes of
/// UTF-8 do not count.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
  }));
}

std::string right(const std::string& text, std::size_t width) {
  return std::string(width - std::min(width, width_of(text)), ' ') + text;
}

/// Returns the headings of the columns: the name of each file without its extension, or the whole
/// path if two names are equal. A heading is never shortened.
std::vector<std::string> headings(const std::vector<std::filesystem::path>& reports) {
  std::vector<std::string> names;
  for (const auto& file : reports) {
    const auto same = std::count_if(reports.begin(), reports.end(),
                                    [&](const auto& other) { return other.stem() == file.stem(); });
    names.push_back(visible(same > 1 ? file.string() : file.stem().string()));
  }
  return names;
}

nlohmann::json read_report(const std::filesystem::path& file) {
  constexpr std::size_t kLargest = std::size_t{16} << 20;  // [bytes] largest size of a report
  try {
    return nlohmann::json::parse(
        read_regular_file(file, kLargest, "give the JSON report of a client"));
  } catch (const nlohmann::json::exception& e) {
    throw std::runtime_error(file.string() + ": is not a JSON report: " + e.what());
  }
}

/// Returns the number of a row in a report, as text; "-" for null: the run has none, for example
/// because the hand felt nothing. Throws std::runtime_error with the name of the file if the report
/// has no such row.
std::string cell(const nlohmann::json& report, const Row& row, const std::filesystem::path& file) {
  const nlohmann::json::json_pointer pointer(row.pointer);
  if (report.contains(pointer) && report[pointer].is_null()) return "-";
  if (!report.contains(pointer) || !report[pointer].is_number())
    throw std::runtime_error(file.string() + ": has no number at " + row.pointer +
                             "; is it the report of a feltwire-client?");
  std::array<char, 32> number;
  std::snprintf(number.data(), number.size(), row.format, report[pointer].get<double>());
  return number.data();
}

}  // namespace

std::string report_table(const std::vector<std::filesystem::path>& reports) {
  constexpr std::size_t kLabels = 46, kNarrowest = 14;
  const std::vector<std::string> names = headings(reports);
  std::vector<nlohmann::json> documents;
  std::vector<std::size_t> widths;
  std::string table(kLabels, ' ');
  for (std::size_t i = 0; i < reports.size(); ++i) {
    documents.push_back(read_report(reports[i]));
    widths.push_back(std::max(kNarrowest, width_of(names[i])));
    table += "  " + right(names[i], widths[i]);
  }
  table += '\n';
  for (const Row& row : kRows) {
    const std::string label = row.label;
    table += label + std::string(kLabels - std::min(kLabels, label.size()), ' ');
    for (std::size_t i = 0; i < documents.size(); ++i)
      table += "  " + right(cell(documents[i], row, reports[i]), widths[i]);
    table += '\n';
  }
  return table + "* negative: the hand gave more than it got\n";
}

}  // namespace feltwire
