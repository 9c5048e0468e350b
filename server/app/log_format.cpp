#include "server/app/log_format.hpp"

#include <spdlog/fmt/chrono.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <ctime>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "core/base/token_text.hpp"
#include "core/base/visible_text.hpp"

namespace feltwire {
namespace {

std::string_view view(spdlog::string_view_t text) { return {text.data(), text.size()}; }

class VisibleFormatter final : public spdlog::formatter {
 public:
  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& line) override {
    const std::string text = visible(without_tokens(view(message.payload)));
    spdlog::details::log_msg shown = message;
    shown.payload = text;
    pattern_.format(shown, line);
    message.color_range_start = shown.color_range_start;  // spdlog colours this part of the line
    message.color_range_end = shown.color_range_end;
  }
  std::unique_ptr<spdlog::formatter> clone() const override {
    return std::make_unique<VisibleFormatter>();
  }

 private:
  spdlog::pattern_formatter pattern_;
};

class JsonFormatter final : public spdlog::formatter {
 public:
  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& line) override {
    const auto text = [](std::string_view part) {
      // Bytes that are not UTF-8 become U+FFFD.
      return nlohmann::json(std::string(part))
          .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    };
    const auto since = message.time.time_since_epoch();
    const auto micros = std::chrono::duration_cast<std::chrono::microseconds>(since).count();
    const std::time_t seconds = static_cast<std::time_t>(micros / 1'000'000);
    std::tm utc{};
    ::gmtime_r(&seconds, &utc);
    fmt::format_to(
        std::back_inserter(line),
        R"({{"time":"{:%Y-%m-%dT%H:%M:%S}.{:06}Z","level":"{}","program":{},"text":{}}})", utc,
        micros % 1'000'000, spdlog::string_view_t(spdlog::level::to_string_view(message.level)),
        text(view(message.logger_name)), text(without_tokens(view(message.payload))));
    line.push_back('\n');
  }
  std::unique_ptr<spdlog::formatter> clone() const override {
    return std::make_unique<JsonFormatter>();
  }
};

}  // namespace

std::unique_ptr<spdlog::formatter> json_log_format() { return std::make_unique<JsonFormatter>(); }

std::unique_ptr<spdlog::formatter> visible_log_format() {
  return std::make_unique<VisibleFormatter>();
}

void open_log(const std::string& name, const std::string& level, const std::string& format) {
  spdlog::set_default_logger(spdlog::stderr_color_mt(name));
  spdlog::set_formatter(format == "json" ? json_log_format() : visible_log_format());
  spdlog::set_level(spdlog::level::from_str(level));
}

}  // namespace feltwire
