// Takes arbitrary bytes as an MCAP file and as messages to write. A file must be read, or the error
// must name its place. A truncated file must give the first messages of the complete file. Written
// messages must be read again.

#include <algorithm>
#include <sstream>
#include <vector>

#include "core/base/file_error.hpp"
#include "core/recording/event_message.hpp"
#include "core/recording/mcap_reader.hpp"
#include "core/recording/mcap_writer.hpp"
#include "core/recording/sample_messages.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace feltwire::fuzz {
namespace {

constexpr mcap::ReaderLimits kLimits{.record = 1 << 20, .chunk = 1 << 20};

struct Written {
  std::uint16_t channel = 0;
  std::uint64_t time = 0;
  std::string data;
  bool operator==(const Written&) const = default;
};

/// Returns the messages up to the end or to the first error.
std::vector<Written> read(const std::string& bytes, bool& whole) {
  std::vector<Written> messages;
  whole = false;
  try {
    std::istringstream in(bytes);
    mcap::Reader reader(in, "file.mcap", kLimits);
    while (const auto message = reader.next()) {
      require(reader.channels().contains(message->channel), "a message has a channel");
      messages.push_back({message->channel, message->log_time, std::string(message->data)});
    }
    whole = !reader.cut_at();
    require(whole || *reader.cut_at() <= bytes.size(), "a file is cut within it");
  } catch (const FileError& error) {
    require(std::string_view(error.what()).starts_with("file.mcap: byte "),
            "an error names its place");
  }
  return messages;
}

void decode(const std::string& data) {
  std::string again;
  if (const auto sample = read_sample(data)) {
    append(again, *sample);
    const auto same_sample = read_sample(again);
    require(same_sample.has_value() && same(same_sample->held, sample->held) &&
                same(same_sample->pose.orientation, sample->pose.orientation) &&
                same(same_sample->age, sample->age),
            "a sample that is read is written the same");
  }
  again.clear();
  if (const auto account = read_account(data)) {
    append(again, *account);
    const auto same_account = read_account(again);
    require(same_account.has_value() && same_account->no_force == account->no_force &&
                same_account->balance.has_value() == account->balance.has_value(),
            "an account that is read is written the same");
  }
  again.clear();
  if (const auto event = read_event(data)) {
    append(again, *event);
    const auto same_event = read_event(again);
    require(same_event.has_value() && same_event->number == event->number &&
                same_event->digest == event->digest && same_event->payload == event->payload,
            "an event that is read is written the same");
  }
}

void write_and_read(Input in) {
  mcap::Writer writer({.zstd = in.coin(), .chunk_bytes = in.byte() + 1u, .chunk_time = in.byte()});
  const auto schema = writer.add(mcap::Schema{"a.B", "protobuf", ""});
  for (const char* topic : {"/one", "/two"}) writer.add(mcap::Channel{schema, topic, "protobuf"});
  std::vector<Written> written;
  while (!in.empty()) {
    const auto channel = static_cast<std::uint16_t>(in.coin() ? 1 : 2);
    const auto time = in.whole<std::uint64_t>();
    const Bytes data = in.bytes(in.byte());
    written.push_back({channel, time, text(data.data(), data.size())});
    writer.write(channel, time, written.back().data);
  }
  writer.finish();
  bool whole = false;
  require(read(writer.take(), whole) == written && whole, "what was written comes back");
}

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire::fuzz;
  const std::string bytes = text(data, size);
  bool whole = false;
  const auto messages = read(bytes, whole);
  for (const Written& message : messages) decode(message.data);
  decode(bytes);
  const auto first = read(bytes.substr(0, size / 2), whole);
  require(
      first.size() <= messages.size() && std::equal(first.begin(), first.end(), messages.begin()),
      "a cut file gives the first messages");
  write_and_read(Input(data, size));
  return 0;
}
