#include "sim/report_table.hpp"

#include <array>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace feltwire {
namespace {

struct Row {
  const char* label;
  const char* pointer;  // JSON pointer into a report
  const char* format;   // of a double
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
    Row{"force off its commanded direction, mean [deg]", "/direction_error_deg/mean", "%.3f"},
    Row{"energy to the hand by contact [J] *", "/energy_delivered_j/elastic", "%.4f"},
    Row{"energy to the hand by friction [J] *", "/energy_delivered_j/frictional", "%.4f"},
    Row{"times the energy bound was broken", "/bound_violations", "%.0f"},
};

}  // namespace

std::string report_table(const std::vector<std::filesystem::path>& reports) {
  std::vector<nlohmann::json> documents;
  std::string table(46, ' ');
  std::array<char, 64> cell;
  for (const auto& file : reports) {
    std::ifstream in(file);
    if (!in)
      throw std::runtime_error(file.string() +
                               ": cannot be read; give the JSON report of a client");
    try {
      documents.push_back(nlohmann::json::parse(in));
    } catch (const nlohmann::json::exception& e) {
      throw std::runtime_error(file.string() + ": is not a JSON report: " + e.what());
    }
    std::snprintf(cell.data(), cell.size(), "  %14s", file.stem().string().substr(0, 14).c_str());
    table += cell.data();
  }
  table += '\n';
  for (const Row& row : kRows) {
    std::array<char, 64> label;
    std::snprintf(label.data(), label.size(), "%-46s", row.label);
    table += label.data();
    for (std::size_t i = 0; i < documents.size(); ++i) {
      const nlohmann::json::json_pointer pointer(row.pointer);
      if (!documents[i].contains(pointer) || !documents[i][pointer].is_number())
        throw std::runtime_error(reports[i].string() + ": has no number at " + row.pointer +
                                 "; is it the report of a feltwire-client?");
      std::array<char, 32> number;
      std::snprintf(number.data(), number.size(), row.format, documents[i][pointer].get<double>());
      std::snprintf(cell.data(), cell.size(), "  %14s", number.data());
      table += cell.data();
    }
    table += '\n';
  }
  return table + "* negative: the hand gave more than it got\n";
}

}  // namespace feltwire
