#include "server/web/viewer_message.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace feltwire::web {
namespace {

/// Keeps the members of the outermost object. No tree is made: the destructor of one allocates, and
/// ends the program where there is no memory.
class Members : public nlohmann::json_sax<nlohmann::json> {
 public:
  ViewerMessage message;

  bool null() override { return value(); }
  bool boolean(bool) override { return value(); }
  bool number_integer(number_integer_t v) override { return number(static_cast<double>(v)); }
  bool number_unsigned(number_unsigned_t v) override { return number(static_cast<double>(v)); }
  bool number_float(number_float_t v, const string_t&) override { return number(v); }
  bool binary(binary_t&) override { return false; }
  bool string(string_t& text) override {
    if (depth_ == 1 && key_ == "token") message.token = text;
    if (depth_ == 1 && key_ == "watch") message.watch = text;
    if (depth_ == 1 && key_ == "ticket") message.ticket = text;
    if (depth_ == 1 && key_ == "hand") message.hand = text;
    return value();
  }
  bool key(string_t& text) override {
    if (depth_ == 1) key_ = text;
    return true;
  }
  bool start_object(std::size_t) override { return enter(); }
  bool end_object() override { return leave(); }
  bool start_array(std::size_t) override {
    if (depth_ == 1) coordinates_ = 0;
    return depth_ > 0 && enter();
  }
  bool end_array() override {
    leave();
    if (depth_ == 1 && key_ == "point")
      message.point = coordinates_ == 3 ? point_ : Vec3::Constant(std::nan(""));
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception&) override {
    return false;
  }

 private:
  static constexpr int kDeepest = 8;
  bool value() const { return depth_ > 0; }
  bool number(double v) {
    if (depth_ == 2 && coordinates_ < 3) point_[coordinates_] = v;
    if (depth_ == 2) coordinates_ = std::min(coordinates_ + 1, 4);
    return value();
  }
  bool enter() { return ++depth_ <= kDeepest; }
  bool leave() {
    --depth_;
    return true;
  }
  int depth_ = 0;
  std::string key_;
  Vec3 point_ = Vec3::Zero();
  int coordinates_ = 0;  // numbers of the array of the outermost object, 4: too many
};

}  // namespace

std::optional<ViewerMessage> parse_viewer_message(std::string_view text) {
  Members members;
  if (!nlohmann::json::sax_parse(text, &members)) return std::nullopt;
  return std::move(members.message);
}

}  // namespace feltwire::web
