// An admin of the C interface, against a server of this process.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/c_api/feltwire.h"
#include "tests/client/c_api/c_api_server.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::c_api_test {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

class AdminApi : public ::testing::Test, protected ApiServer {
 protected:
  AdminApi() : ApiServer(testing::floor_scene(), {observer_token().token}) {
    const fw_admin_options options = admin_options();
    EXPECT_EQ(fw_admin_open(&options, &admin_), FW_OK) << fw_last_error();
  }
  ~AdminApi() override { EXPECT_EQ(fw_admin_close(admin_), FW_OK); }

  /// Returns the result of a command, and its answer in `answer`.
  static std::int32_t request(fw_admin* admin, const std::vector<const char*>& words,
                              const char** answer) {
    return fw_admin_request(admin, words.data(), static_cast<std::uint32_t>(words.size()), answer);
  }
  Json ask(const std::vector<const char*>& words) {
    const char* answer = nullptr;
    EXPECT_EQ(request(admin_, words, &answer), FW_OK) << fw_last_error();
    return answer != nullptr ? Json::parse(answer) : Json();
  }
  void fails(const std::vector<const char*>& words, std::int32_t result, const char* text) {
    const char* answer = "";
    EXPECT_EQ(request(admin_, words, &answer), result) << text;
    EXPECT_THAT(fw_last_error(), HasSubstr(text));
    EXPECT_EQ(answer, nullptr);
  }

  static const IssuedToken& observer_token() {
    static const IssuedToken issued = issue_token("eye", "*", Role::observer, std::nullopt);
    return issued;
  }

  fw_admin* admin_ = nullptr;
};

TEST_F(AdminApi, ListsChangesAndEvicts) {
  const Json scenes = ask({"scenes"});
  ASSERT_EQ(scenes.size(), 1u);
  EXPECT_EQ(scenes[0]["scene"], "floor");
  EXPECT_EQ(scenes[0]["objects"], 1);
  EXPECT_EQ(ask({"sessions"}), Json::array());
  fw_hand* hand = nullptr;
  const fw_hand_options options = hand_options();
  ASSERT_EQ(fw_hand_open(&options, &hand), FW_OK) << fw_last_error();
  const Json sessions = ask({"sessions", "--scene", "floor"});
  ASSERT_EQ(sessions.size(), 1u);
  EXPECT_EQ(sessions[0]["client"], "libfeltwire");
  EXPECT_EQ(sessions[0]["number"], 1);
  const Json changed = ask({"set", "--object", "floor", "--stiffness", "250"});
  EXPECT_EQ(changed["scene"], "floor");
  EXPECT_THAT(changed["change"].get<std::string>(), HasSubstr("250"));
  // A hand of the library takes no change unless its owner allowed it.
  fails({"set", "--session", "1", "--mode", "contact_frame"}, FW_ERROR_REFUSED, "--changes");
  EXPECT_FALSE(ask({"stats"})["scenes"].empty());
  const Json evicted = ask({"evict", "1"});
  EXPECT_EQ(evicted["client"], "libfeltwire");
  EXPECT_EQ(evicted["session"], sessions[0]["session"]);
  fw_hand_close(hand);
}

TEST_F(AdminApi, WrongCommandsAreNamed) {
  fails({}, FW_ERROR_ARGUMENT, "give a command");
  fails({"sesions"}, FW_ERROR_ARGUMENT, "did you mean sessions");
  fails({"sessions", nullptr}, FW_ERROR_ARGUMENT, "null word");
  fails({"evict"}, FW_ERROR_ARGUMENT, "SESSION");
  fails({"evict", "7"}, FW_ERROR_ARGUMENT, "there is no session 7");
  fails({"sessions", "--help"}, FW_ERROR_ARGUMENT, "feltwire-client only");
  fails({"sessions", "--connect", "localhost:1"}, FW_ERROR_ARGUMENT, "--connect");
  fails({"set", "--object", "floor", "--stiffness", "-3"}, FW_ERROR_REFUSED, "stiffness");
  fails({"record"}, FW_ERROR_REFUSED, "flight");
  const char* words[] = {"sessions"};
  EXPECT_EQ(fw_admin_request(admin_, words, 1, nullptr), FW_ERROR_ARGUMENT);
  EXPECT_EQ(fw_admin_close(nullptr), FW_OK);
}

TEST_F(AdminApi, ATokenOfAnObserverMayListAndChangeNothing) {
  const std::string file = write_token("eye", observer_token());
  fw_admin_options options = admin_options();
  options.token_file = file.c_str();
  fw_admin* eye = nullptr;
  ASSERT_EQ(fw_admin_open(&options, &eye), FW_OK) << fw_last_error();
  const char* answer = nullptr;
  EXPECT_EQ(request(eye, {"sessions"}, &answer), FW_OK) << fw_last_error();
  EXPECT_EQ(request(eye, {"set", "--object", "floor", "--stiffness", "250"}, &answer),
            FW_ERROR_REFUSED);
  EXPECT_THAT(fw_last_error(), HasSubstr("admin"));
  EXPECT_EQ(fw_admin_close(eye), FW_OK);
}

TEST_F(AdminApi, AServerThatIsNotThereIsToldAtOnce) {
  fw_admin_options options = admin_options();
  fw_admin* admin = nullptr;
  options.server = nullptr;
  EXPECT_EQ(fw_admin_open(&options, &admin), FW_ERROR_ARGUMENT);
  EXPECT_THAT(fw_last_error(), HasSubstr("admin_options.server is null"));
  EXPECT_EQ(fw_admin_open(nullptr, &admin), FW_ERROR_ARGUMENT);
  options = admin_options();
  options.struct_size = 12;
  EXPECT_EQ(fw_admin_open(&options, &admin), FW_ERROR_ARGUMENT);
  EXPECT_THAT(fw_last_error(), HasSubstr("fw_admin_options_default() first"));
  server.reset();
  options = admin_options();
  EXPECT_EQ(fw_admin_open(&options, &admin), FW_ERROR_SERVER);
  EXPECT_EQ(admin, nullptr);
  fails({"sessions"}, FW_ERROR_SERVER, "");
}

}  // namespace
}  // namespace feltwire::c_api_test
