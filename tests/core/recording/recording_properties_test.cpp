#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <bit>

#include "core/recording/protobuf.hpp"
#include "core/recording/sample_messages.hpp"
#include "tests/core/recording/recordings.hpp"

namespace feltwire::recording_properties_test {
namespace {

using test::read_mcap;
using test::ReadFile;
using test::ReadMessage;

double any_double() { return std::bit_cast<double>(*rc::gen::arbitrary<std::uint64_t>()); }
Vec3 any_vector() {
  const double x = any_double(), y = any_double(), z = any_double();
  return {x, y, z};
}
bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}
template <class Vector>
bool same(const Vector& a, const Vector& b) {
  for (int i = 0; i < a.size(); ++i)
    if (!same(a[i], b[i])) return false;
  return true;
}

RC_GTEST_PROP(McapProperty, EveryMessageComesBack, ()) {
  const bool zstd = *rc::gen::arbitrary<bool>();
  const auto chunk_bytes = *rc::gen::inRange<std::size_t>(1, 5000);
  const int channels = *rc::gen::inRange(1, 5);
  mcap::Writer writer({.zstd = zstd,
                       .chunk_bytes = chunk_bytes,
                       .chunk_time = *rc::gen::inRange<std::uint64_t>(0, 1000)});
  std::string bytes;
  for (int i = 0; i < channels; ++i) {
    const auto schema = writer.add(mcap::Schema{*rc::gen::arbitrary<std::string>(), "protobuf",
                                                *rc::gen::arbitrary<std::string>()});
    writer.add(mcap::Channel{schema, "/" + std::to_string(i), "protobuf"});
  }
  std::vector<ReadMessage> written;
  std::vector<std::uint32_t> sequence(static_cast<std::size_t>(channels), 0);
  const int count = *rc::gen::inRange(0, 100);
  for (int i = 0; i < count; ++i) {
    const int channel = *rc::gen::inRange(0, channels);
    const auto time = *rc::gen::inRange<std::uint64_t>(0, 10000);
    const auto data = *rc::gen::arbitrary<std::string>();
    writer.write(static_cast<std::uint16_t>(channel + 1), time, data);
    written.push_back(
        {"/" + std::to_string(channel), data, sequence[static_cast<std::size_t>(channel)]++, time});
    if (*rc::gen::inRange(0, 10) == 0) bytes += writer.take();
  }
  writer.finish();
  bytes += writer.take();
  RC_ASSERT(writer.size() == bytes.size());

  const ReadFile file = read_mcap(bytes);
  RC_ASSERT(file.messages == written);
  RC_ASSERT(!file.cut_at);
  RC_ASSERT(file.statistics->messages == written.size());

  // The file is cut at any byte. The first messages must remain.
  const auto cut = *rc::gen::inRange<std::size_t>(0, bytes.size());
  const ReadFile part = read_mcap(bytes.substr(0, cut));
  RC_ASSERT(part.cut_at.has_value());
  RC_ASSERT(part.messages.size() <= written.size());
  RC_ASSERT(std::equal(part.messages.begin(), part.messages.end(), written.begin()));
}

RC_GTEST_PROP(MessageProperty, ASampleComesBackToTheBit, ()) {
  const double w = any_double(), x = any_double(), y = any_double(), z = any_double();
  const RecordedSample sample{.time = any_double(),
                              .pose = {any_vector(), Quaternion(w, x, y, z)},
                              .elastic = any_vector(),
                              .frictional = any_vector(),
                              .held = any_vector(),
                              .torque = any_vector(),
                              .age = any_double()};
  std::string bytes;
  append(bytes, sample);
  const auto read = read_sample(bytes);
  RC_ASSERT(read.has_value());
  RC_ASSERT(same(read->time, sample.time));
  RC_ASSERT(same(read->pose.position, sample.pose.position));
  RC_ASSERT(same(read->pose.orientation.coeffs(), sample.pose.orientation.coeffs()));
  RC_ASSERT(same(read->elastic, sample.elastic));
  RC_ASSERT(same(read->frictional, sample.frictional));
  RC_ASSERT(same(read->held, sample.held));
  RC_ASSERT(same(read->torque, sample.torque));
  RC_ASSERT(same(read->age, sample.age));
  // A part of a message must give another message or none.
  read_sample(std::string_view(bytes).substr(0, *rc::gen::inRange<std::size_t>(0, bytes.size())));
}

RC_GTEST_PROP(MessageProperty, AnAccountComesBackToTheBit, ()) {
  const RecordedAccount account{
      .time = any_double(),
      .balance = *rc::gen::arbitrary<bool>() ? std::optional(any_double()) : std::nullopt,
      .cut = any_double(),
      .no_force = *rc::gen::arbitrary<std::uint32_t>()};
  std::string bytes;
  append(bytes, account);
  const auto read = read_account(bytes);
  RC_ASSERT(read.has_value());
  RC_ASSERT(same(read->time, account.time));
  RC_ASSERT(read->balance.has_value() == account.balance.has_value());
  RC_ASSERT(same(read->balance.value_or(0.0), account.balance.value_or(0.0)));
  RC_ASSERT(same(read->cut, account.cut));
  RC_ASSERT(read->no_force == account.no_force);
}

RC_GTEST_PROP(MessageProperty, AnyBytesAreReadOrRefused, ()) {
  const auto bytes = *rc::gen::arbitrary<std::string>();
  read_sample(bytes);
  read_account(bytes);
}

TEST(Protobuf, LongMessagesHaveLongLengths) {
  std::string out;
  protobuf::put_message(out, 1, [](std::string& to) {
    protobuf::put(to, 2, std::string_view(std::string(300, 'x')));
  });
  protobuf::Fields fields(out);
  const auto field = fields.next();
  ASSERT_TRUE(field && field->is_bytes);
  protobuf::Fields inner(field->bytes);
  EXPECT_EQ(inner.next()->bytes, std::string(300, 'x'));
  EXPECT_FALSE(fields.next());
  EXPECT_TRUE(fields.ok());
}

TEST(Protobuf, BrokenFieldsAreRefused) {
  using namespace std::string_literals;
  for (const std::string& bytes :
       {"\x08"s, "\x0a\x05yz"s, "\x09\x01"s, "\x00\x01"s, "\x0b"s, "\x0d\x01\x02"s,
        std::string(11, '\xff'), "\x08" + std::string(10, '\xff')}) {
    protobuf::Fields fields(bytes);
    while (fields.next()) {
    }
    EXPECT_FALSE(fields.ok());
  }
}

}  // namespace
}  // namespace feltwire::recording_properties_test
