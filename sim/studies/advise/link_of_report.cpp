#include "sim/studies/advise/link_of_report.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/base/file_error.hpp"
#include "core/base/json_document.hpp"
#include "core/base/units.hpp"

namespace feltwire::advise {
namespace {

using ReportJson = nlohmann::json;

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& why) {
  throw FileError(file.string() + ": " + why +
                  "; give a report of feltwire-client --report of a run that the server answered");
}

/// Returns a number of the report that is finite and not negative.
double number_of(const ReportJson& json, const char* member, const std::filesystem::path& file) {
  const auto found = json.find(member);
  if (found == json.end() || !found->is_number()) refuse(file, std::string(member) + " is missing");
  const double value = found->get<double>();
  if (!std::isfinite(value) || value < 0.0) refuse(file, std::string(member) + " is negative");
  return value;
}

/// Whether the text is HOST:PORT, as of --connect.
bool is_server(const std::string& text) {
  const auto colon = text.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == text.size()) return false;
  return text.find('=') == std::string::npos &&
         std::all_of(text.begin() + static_cast<std::ptrdiff_t>(colon) + 1, text.end(),
                     [](unsigned char c) { return std::isdigit(c) != 0; });
}

}  // namespace

TwoWayLinkOptions link_of_report(const std::filesystem::path& file) {
  const ReportJson json = ReportJson::parse(read_text(file), nullptr, false);
  if (json.is_discarded() || !json.is_object()) refuse(file, "it is no JSON object");
  const auto clock = json.find("server_clock");
  if (clock == json.end() || !clock->is_object()) refuse(file, "server_clock is missing");
  TwoWayLinkOptions link;
  link.up.delay = number_of(*clock, "delay_up_us", file) / kMicro;
  link.down.delay = number_of(*clock, "delay_down_us", file) / kMicro;
  link.up.jitter = number_of(*clock, "jitter_up_us", file) / kMicro;
  link.down.jitter = number_of(*clock, "jitter_down_us", file) / kMicro;
  const double sent = number_of(json, "sample_datagrams", file);
  const double lost = number_of(json, "lost", file);
  if (!(sent > 0.0)) refuse(file, "sample_datagrams is 0");
  // A lost sample lost its datagram or its answer.
  const double share = std::min(1.0, lost / sent);
  link.up.loss = link.down.loss = 1.0 - std::sqrt(1.0 - share);
  link.text = file.filename().string();
  validate(link.up);
  validate(link.down);
  return link;
}

TwoWayLinkOptions link_of(const std::string& text) {
  if (text.ends_with(".json")) return link_of_report(text);
  if (is_server(text))
    throw std::invalid_argument(
        "--link: this command measures no server; run feltwire-client "
        "--connect " +
        text +
        " --scene NAME --duration 10 --report run.json, then give --link "
        "run.json");
  return parse_link(text);
}

}  // namespace feltwire::advise
