// The command line selects the trusted server and the token.

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/client/app/parsed_options.hpp"
#include "tests/client/temporary_folder.hpp"

namespace feltwire::options_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::text_of;

const Credentials& credentials_of(const std::variant<ClientOptions, int>& options) {
  return std::get<ClientOptions>(options).server.credentials;
}

TEST(Trust, IsSaidInExactlyOneWay) {
  ::setenv("FELTWIRE_TOKEN", "fw_of_a_test", 1);
  EXPECT_THAT(refusal({}, true), AllOf(HasSubstr("--fingerprint"), HasSubstr("--ca")));
  testing::TemporaryFolder folder;
  const std::string print = folder / "fingerprint", ca = folder / "ca.pem";
  std::ofstream(print) << kPrint << "\n";
  std::ofstream(ca) << "an authority";
  EXPECT_THAT(refusal({"--ca", ca}), HasSubstr("give one"));
  EXPECT_THAT(refusal({"--fingerprint-file", print}), HasSubstr("give one"));
  EXPECT_THAT(refusal({"--fingerprint", "12ab"}, true), HasSubstr("no fingerprint"));
  EXPECT_THAT(refusal({"--fingerprint-file", folder / "none"}, true),
              AllOf(HasSubstr("--fingerprint-file"), HasSubstr("cannot be opened")));

  Fingerprint expected;
  expected.fill(0xaa);
  const auto pinned = parsed_bare({"--fingerprint-file", print});
  EXPECT_EQ(std::get<Fingerprint>(credentials_of(pinned).trust), expected);
  const auto signed_by = parsed_bare({"--ca", ca});
  EXPECT_EQ(std::get<Authorities>(credentials_of(signed_by).trust).certificates, "an authority");
}

TEST(Trust, ATokenComesFromAFileOrTheEnvironmentAlone) {
  testing::TemporaryFolder folder;
  const std::string file = folder / "token";
  std::ofstream(file) << "fw_of_a_file\n";
  ::chmod(file.c_str(), 0600);
  EXPECT_EQ(credentials_of(parsed({})).token.text(), "fw_of_a_test");
  EXPECT_EQ(credentials_of(parsed({"--token-file", file})).token.text(), "fw_of_a_file");
  EXPECT_THAT(refusal({"--token-file", folder / "none"}), HasSubstr("--token-file"));
  EXPECT_THAT(refusal({"--token", "fw_x"}), HasSubstr("--token"));  // This option does not exist.
  ::unsetenv("FELTWIRE_TOKEN");
  EXPECT_THAT(refusal({"--fingerprint", kPrint}, true),
              AllOf(HasSubstr("--token-file"), HasSubstr("FELTWIRE_TOKEN")));
}

TEST(Trust, ACertificateComesWithItsKey) {
  testing::TemporaryFolder folder;
  const std::string file = folder / "x.pem";
  std::ofstream(file) << "PEM";
  EXPECT_THAT(refusal({"--certificate", file}), HasSubstr("--key"));
  ::chmod(file.c_str(), 0600);
  const auto both = parsed({"--certificate", file, "--key", file});
  EXPECT_EQ(credentials_of(both).certificate, "PEM");
  EXPECT_EQ(credentials_of(both).key.text(), "PEM");
}

TEST(Trust, AKeyThatOthersMayReadIsRefusedAndATokenWarnedOf) {
  testing::TemporaryFolder folder;
  const std::string file = folder / "secret", key = "--key: " + file;
  std::ofstream(file) << "fw_secret";
  for (const auto& [mode, text] : {std::pair<mode_t, const char*>{0644, "(mode 0644)"},
                                   {0640, "(mode 0640)"},
                                   {0620, "(mode 0620)"},
                                   {0601, "(mode 0601)"}}) {
    ::chmod(file.c_str(), mode);
    EXPECT_THAT(refusal({"--certificate", file, "--key", file}),
                AllOf(HasSubstr(key), HasSubstr(text), HasSubstr("chmod 600 " + file)));
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(credentials_of(parsed({"--token-file", file})).token.text(), "fw_secret");
    EXPECT_THAT(::testing::internal::GetCapturedStderr(),
                AllOf(HasSubstr("warning"), HasSubstr("chmod 600 " + file)));
  }
  for (const mode_t mode : {0600, 0400}) {
    ::chmod(file.c_str(), mode);
    EXPECT_EQ(credentials_of(parsed({"--certificate", file, "--key", file})).key.text(),
              "fw_secret");
    ::testing::internal::CaptureStderr();
    parsed({"--token-file", file});
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  }
}

}  // namespace
}  // namespace feltwire::options_test
