#include "client/emulated_link/link_options.hpp"

#include <gmock/gmock.h>

#include <sstream>

#include "core/base/csv.hpp"
#include "tests/client/temporary_folder.hpp"

namespace feltwire::link_options_test {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

std::string complaint(const std::string& text) {
  return error_of<std::invalid_argument>([&] { parse_link(text); });
}

TEST(LinkOptions, EveryKeyIsReadInItsUnit) {
  const TwoWayLinkOptions link = parse_link(
      "delay=25,jitter=5.5,distribution=pareto,order=free,loss=10,burst=4,reorder=2,"
      "reorder_delay=7,duplicate=3,rate=1.5,queue=20,seed=18446744073709551615");
  EXPECT_EQ(link.seed, 18446744073709551615u);
  for (const LinkOptions& one : {link.up, link.down}) {
    EXPECT_DOUBLE_EQ(one.delay, 25e-3);
    EXPECT_DOUBLE_EQ(one.jitter, 5.5e-3);
    EXPECT_EQ(one.distribution, Jitter::pareto);
    EXPECT_FALSE(one.keep_order);
    EXPECT_DOUBLE_EQ(one.loss, 0.1);
    EXPECT_DOUBLE_EQ(one.burst, 4);
    EXPECT_DOUBLE_EQ(one.reorder, 0.02);
    EXPECT_DOUBLE_EQ(one.reorder_delay, 7e-3);
    EXPECT_DOUBLE_EQ(one.duplicate, 0.03);
    EXPECT_DOUBLE_EQ(one.rate, 1.5e6);
    EXPECT_DOUBLE_EQ(one.queue, 20e3);
  }
}

TEST(LinkOptions, DirectionsAndOrder) {
  const TwoWayLinkOptions link = parse_link("delay=5,up.delay=7,down.loss=2,loss=1,up.order=free");
  EXPECT_DOUBLE_EQ(link.up.delay, 7e-3);
  EXPECT_DOUBLE_EQ(link.down.delay, 5e-3);
  EXPECT_DOUBLE_EQ(link.up.loss, 0.01);
  EXPECT_DOUBLE_EQ(link.down.loss, 0.01);  // the later option wins
  EXPECT_FALSE(link.up.keep_order);
  EXPECT_TRUE(link.down.keep_order);
}

TEST(LinkOptions, AProfileIsAStartThatLaterItemsChange) {
  const TwoWayLinkOptions link = parse_link("wifi,loss=5,down.satellite,seed=9");
  EXPECT_DOUBLE_EQ(link.up.delay, 2e-3);
  EXPECT_DOUBLE_EQ(link.up.loss, 0.05);
  EXPECT_DOUBLE_EQ(link.down.delay, 279e-3);
  EXPECT_DOUBLE_EQ(link.down.rate, 25e6);
  EXPECT_EQ(link.seed, 9u);
  EXPECT_EQ(link.text, "wifi,loss=5,down.satellite,seed=9");
}

TEST(LinkOptions, EveryProfileCanBeAndStandsInTheManual) {
  const std::string manual = testing::text_of(FELTWIRE_SOURCE_DIR "/docs/link.md");
  for (const LinkProfile& profile : kLinkProfiles) {
    EXPECT_GT(parse_link(profile.name).up.delay, 0.0) << profile.name;
    EXPECT_THAT(manual, HasSubstr("| `" + std::string(profile.name) + "` | `" +
                                  std::string(profile.items) + "` |"));
  }
}

TEST(LinkOptions, ErrorsNameTheItemAndTheRemedy) {
  EXPECT_THAT(complaint("dely=5"), AllOf(HasSubstr("'dely'"), HasSubstr("keys are delay, jitter")));
  EXPECT_THAT(complaint("wfi"), AllOf(HasSubstr("'wfi'"), HasSubstr("profiles are lan, wifi")));
  EXPECT_THAT(complaint(""), HasSubstr("''"));
  EXPECT_THAT(complaint("wifi,"), HasSubstr("''"));
  EXPECT_THAT(complaint("delay=-1"), AllOf(HasSubstr("delay=-1"), HasSubstr("0 to 10000 ms")));
  EXPECT_THAT(complaint("delay=5ms"),
              HasSubstr("delay=5ms: write the number without unit; it is in ms: delay=5"));
  EXPECT_THAT(complaint("loss=2.5%"), HasSubstr("without unit; it is in %: loss=2.5"));
  EXPECT_THAT(complaint("up.rate=1e1Mbit/s"), HasSubstr("without unit; it is in Mbit/s: rate=1e1"));
  EXPECT_THAT(complaint("delay=0.015s"), HasSubstr("without unit; it is in ms: delay=15"));
  EXPECT_THAT(complaint("rate=500kbit/s"), HasSubstr("it is in Mbit/s: rate=0.5"));
  EXPECT_THAT(complaint("delay=1min"), ::testing::EndsWith("without unit; it is in ms"));
  EXPECT_THAT(complaint("delay=fast"), HasSubstr("delay=fast must be a number"));
  EXPECT_THAT(complaint("jitter="), HasSubstr("jitter= must be a number"));
  EXPECT_THAT(complaint("loss=nan"), HasSubstr("loss=nan"));
  EXPECT_THAT(complaint("loss=100.1"), HasSubstr("0 to 100 %"));
  EXPECT_THAT(complaint("burst=0.5"), HasSubstr("from 1 to"));
  EXPECT_THAT(complaint("rate=0"), HasSubstr("0.001 to 100000 Mbit/s"));
  EXPECT_THAT(complaint("distribution=cauchy"), HasSubstr("use normal, uniform, pareto"));
  EXPECT_THAT(complaint("order=maybe"), HasSubstr("keep"));
  EXPECT_THAT(complaint("seed=-1"), HasSubstr("seed=-1"));
  EXPECT_THAT(complaint("up.seed=1"), HasSubstr("both directions"));
  EXPECT_THAT(complaint("left.delay=1"), HasSubstr("'left.delay'"));
}

TEST(LinkOptions, AChainThatCannotBeIsRefused) {
  EXPECT_THAT(complaint("loss=60,burst=1"), AllOf(HasSubstr("loss=60"), HasSubstr("raise burst")));
  EXPECT_NO_THROW(parse_link("loss=50,burst=1"));
  EXPECT_NO_THROW(parse_link("loss=100"));
}

class LinkTraceFile : public ::testing::Test {
 protected:
  TemporaryFolder folder;
  std::string file(const std::string& text) {
    std::ofstream(folder / "trace.csv") << text;
    return (folder / "trace.csv").string();
  }
  std::string trace_complaint(const std::string& text) {
    return error_of<CsvError>([&] { parse_link("trace:" + file(text)); });
  }
};

TEST_F(LinkTraceFile, IsReadForTheDirectionAskedFor) {
  const auto link =
      parse_link("up.trace:" + file("t,delay,lost,note\n5,0.01,0,a\n6,0,1,b\n") + ",down.delay=3");
  ASSERT_TRUE(link.up.trace);
  EXPECT_FALSE(link.down.trace);
  ASSERT_EQ(link.up.trace->rows.size(), 2u);
  EXPECT_EQ(link.up.trace->rows[1].time, std::chrono::seconds(1));
  EXPECT_EQ(link.up.trace->rows[0].delay, std::chrono::milliseconds(10));
  EXPECT_TRUE(link.up.trace->rows[1].lost);
  EXPECT_EQ(link.up.trace->period, std::chrono::seconds(2));
}

TEST_F(LinkTraceFile, OneRowHoldsForEver) {
  const auto link = parse_link("trace:" + file("t,delay,lost\n3,0.01,0\n"));
  EXPECT_EQ(link.up.trace->at(std::chrono::hours(5)).delay, std::chrono::milliseconds(10));
}

TEST_F(LinkTraceFile, ErrorsNameLineAndColumn) {
  EXPECT_THAT(trace_complaint("t,delay\n0,1\n"), HasSubstr("column 'lost'"));
  EXPECT_THAT(trace_complaint("t,delay,lost\n"), HasSubstr("no rows"));
  EXPECT_THAT(trace_complaint("t,delay,lost\n0,0,0\n0,0,0\n"), HasSubstr(":3: column 't'"));
  EXPECT_THAT(trace_complaint("t,delay,lost\n0,0,0\n2e7,0,0\n"), HasSubstr(":3: column 't'"));
  EXPECT_THAT(trace_complaint("t,delay,lost\n0,25,0\n"), HasSubstr(":2: column 'delay'"));
  EXPECT_THAT(trace_complaint("t,delay,lost\n0,-0.1,0\n"), HasSubstr(":2: column 'delay'"));
  EXPECT_THAT(trace_complaint("t,delay,lost\n0,0,0.5\n"), HasSubstr(":2: column 'lost'"));
  EXPECT_THAT(error_of<CsvError>([] { parse_link("trace:/proc/nowhere/t.csv"); }),
              HasSubstr("/proc/nowhere/t.csv"));
  const std::string good = file("t,delay,lost\n0,0.01,0\n");
  EXPECT_THAT(complaint("trace:" + good + ",loss=5"), HasSubstr("already says delay and loss"));
}

}  // namespace
}  // namespace feltwire::link_options_test
