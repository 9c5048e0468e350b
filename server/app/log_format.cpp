#include "server/app/log_format.hpp"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <string>

#include "core/base/visible_text.hpp"

namespace feltwire {
namespace {

class VisibleFormatter final : public spdlog::formatter {
 public:
  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& line) override {
    const std::string text = visible({message.payload.data(), message.payload.size()});
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

}  // namespace

std::unique_ptr<spdlog::formatter> visible_log_format() {
  return std::make_unique<VisibleFormatter>();
}

void open_log(const std::string& name, const std::string& level) {
  spdlog::set_default_logger(spdlog::stderr_color_mt(name));
  spdlog::set_formatter(visible_log_format());
  spdlog::set_level(spdlog::level::from_str(level));
}

}  // namespace feltwire
