#include "server/web/foxglove_messages.hpp"

#include <openssl/evp.h>

#include <array>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/base/little_endian.hpp"
#include "core/build_info/build_info.hpp"
#include "core/recording/live_messages.hpp"
#include "core/recording/sample_messages.hpp"
#include "server/access/json_text.hpp"

namespace feltwire::web {
namespace {

using json_text::text;

struct Channel {
  std::string_view topic;
  mcap::Schema (*schema)();
};
// The index is a FoxgloveChannel.
constexpr std::array<Channel, kFoxgloveChannels> kChannels = {
    {{"/scene/geometry", picture_schema},
     {"/scene/transforms", transforms_schema},
     {"/scene/picture", picture_schema},
     {"/scene/hands", hands_schema}}};

std::string base64(std::string_view bytes) {
  constexpr std::size_t kGroup = 3, kLetters = 4;
  // Add one byte, because EVP_EncodeBlock() writes a zero after the text.
  std::string encoded((bytes.size() + kGroup - 1) / kGroup * kLetters + 1, '\0');
  const int length = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(encoded.data()),
                                     reinterpret_cast<const unsigned char*>(bytes.data()),
                                     static_cast<int>(bytes.size()));
  encoded.resize(static_cast<std::size_t>(length));
  return encoded;
}

/// Stores the operation and the ids of a request while its text is parsed. It builds no JSON tree,
/// because the destructor of a tree allocates memory, and ends the program if there is none.
class Request : public nlohmann::json_sax<nlohmann::json> {
 public:
  FoxgloveRequest request;

  bool null() override { return value(); }
  bool boolean(bool) override { return value(); }
  bool number_integer(number_integer_t) override { return value() && !is_id(); }
  bool number_unsigned(number_unsigned_t number) override { return value() && take(number); }
  bool number_float(number_float_t, const string_t&) override { return value() && !is_id(); }
  bool binary(binary_t&) override { return false; }
  bool string(string_t& text) override {
    if (depth_ == 1 && key_ == "op") request.operation = text;
    return value() && !is_id();
  }
  bool key(string_t& text) override {
    if (depth_ == 1) key_ = text;
    if (depth_ == kEntry) member_ = text;
    return true;
  }
  bool start_object(std::size_t) override {
    if (depth_ == kEntry - 1 && key_ == "subscriptions") request.subscriptions.emplace_back();
    return enter();
  }
  bool end_object() override { return leave(); }
  bool start_array(std::size_t) override { return depth_ > 0 && enter(); }
  bool end_array() override { return leave(); }
  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception&) override {
    return false;
  }

 private:
  static constexpr int kDeepest = 8;
  static constexpr int kEntry = 3;  // depth of an entry: {"subscriptions": [{here}]}
  bool value() const { return depth_ > 0; }
  bool enter() {
    member_.clear();
    return ++depth_ <= kDeepest;
  }
  bool leave() {
    member_.clear();
    --depth_;
    return true;
  }
  bool in_entry() const {
    return depth_ == kEntry && key_ == "subscriptions" && !request.subscriptions.empty();
  }
  bool is_id() const {
    return (in_entry() && (member_ == "id" || member_ == "channelId")) ||
           (depth_ == kEntry - 1 && key_ == "subscriptionIds");
  }
  bool take(std::uint64_t number) {
    if (!is_id()) return true;
    if (number > std::numeric_limits<std::uint32_t>::max()) return false;
    const auto id = static_cast<std::uint32_t>(number);
    if (!in_entry())
      request.ended.push_back(id);
    else if (member_ == "id")
      request.subscriptions.back().id = id;
    else
      request.subscriptions.back().channel = id;
    return true;
  }
  int depth_ = 0;
  std::string key_, member_;
};

}  // namespace

std::string foxglove_server_info(std::string_view scene) {
  return json_text::object(
      {{"op", text("serverInfo")},
       {"name", text("feltwire-server " + version() + ": " + std::string(scene))},
       {"capabilities", "[]"},
       {"supportedEncodings", "[]"},
       {"metadata", json_text::object({{"scene", text(scene)}})}});
}

std::string foxglove_advertisement() {
  std::vector<std::string> channels;
  for (std::size_t i = 0; i < kChannels.size(); ++i) {
    const mcap::Schema schema = kChannels[i].schema();
    channels.push_back(json_text::object({{"id", json_text::number(std::uint64_t{i})},
                                          {"topic", text(kChannels[i].topic)},
                                          {"encoding", text(kProtobuf)},
                                          {"schemaName", text(schema.name)},
                                          {"schemaEncoding", text(schema.encoding)},
                                          {"schema", text(base64(schema.data))}}));
  }
  return json_text::object({{"op", text("advertise")}, {"channels", json_text::list(channels)}});
}

std::string foxglove_status(FoxgloveLevel level, std::string_view message) {
  return json_text::object({{"op", text("status")},
                            {"level", json_text::number(static_cast<std::uint64_t>(level))},
                            {"message", text(message)}});
}

Bytes foxglove_data_head(std::uint32_t subscription, std::uint64_t time) {
  constexpr std::uint8_t kMessageData = 1;
  constexpr std::size_t kTimeAt = 5, kHead = 13;
  Bytes bytes(kHead);
  bytes[0] = kMessageData;
  put_little_endian(bytes.data() + 1, subscription);
  put_little_endian(bytes.data() + kTimeAt, time);
  return bytes;
}

std::optional<FoxgloveRequest> parse_foxglove_request(std::string_view text) {
  Request read;
  if (!nlohmann::json::sax_parse(text, &read) || read.request.operation.empty())
    return std::nullopt;
  return std::move(read.request);
}

}  // namespace feltwire::web
