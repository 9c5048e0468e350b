// Tests admins with rights for some scenes only.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/app/server.hpp"
#include "tests/server/make.hpp"
#include "tests/server/raw_socket.hpp"

namespace feltwire::admin_test {
namespace {

using control::RefusalCode;
using control::Refused;
using test::ControlClient;

Scene named(const std::string& name) {
  Object floor;
  floor.name = "floor";
  floor.shape = Plane{};
  floor.material.stiffness = 500.0;
  return Scene(name, {floor});
}

/// An admin of one scene must get answers as if the sessions of another scene did not exist.
TEST(Admin, OfOneSceneKnowsAndTouchesNothingOfAnother) {
  const IssuedToken of_lab = issue_token("lab admin", "lab", Role::admin, std::nullopt);
  std::vector<Scene> scenes;
  scenes.push_back(named("lab"));
  scenes.push_back(named("theatre"));
  Server server(test::any_port(), std::move(scenes), test::security({of_lab.token}));
  ControlClient everywhere(server.control_port());
  const auto join = [&](const std::string& scene) {
    control::JoinRequest request = test::join_request();
    request.scene = scene;
    return everywhere.join(request).accepted.session;
  };
  const std::uint64_t here = join("lab"), there = join("theatre");
  constexpr std::uint64_t kNone = 0x123456789a00;

  ControlClient admin(server.control_port(), AF_INET, of_lab.text);
  const auto listed = admin.ask<control::SessionList>(control::ListSessions{}).sessions;
  ASSERT_EQ(listed.size(), 1u);
  EXPECT_EQ(listed[0].session, here);
  EXPECT_EQ(everywhere.ask<control::SessionList>(control::ListSessions{}).sessions.size(), 2u);

  const auto refusals = [&](std::uint64_t session) {
    std::vector<std::string> reasons;
    for (const control::Message& request :
         {control::Message(control::Evict{session}),
          control::Message(control::SetParameters{session, test::server_bounds()}),
          control::Message(control::LeaveRequest{session})}) {
      const auto refused = admin.ask<Refused>(request);
      EXPECT_EQ(refused.code, RefusalCode::unknown_session);
      reasons.push_back(refused.reason);
    }
    return reasons;
  };
  std::vector<std::string> of_none = refusals(kNone);
  for (std::string& reason : of_none)
    reason.replace(reason.find(std::to_string(kNone)), std::to_string(kNone).size(),
                   std::to_string(there));
  EXPECT_EQ(refusals(there), of_none);
  EXPECT_EQ(everywhere.ask<control::SessionList>(control::ListSessions{}).sessions.size(), 2u);
  EXPECT_EQ(admin.ask<Refused>(control::ReloadScene{"theatre"}).code, RefusalCode::unknown_scene);

  admin.ask<control::ParametersSet>(control::SetParameters{here, test::server_bounds()});
  EXPECT_EQ(admin.ask<control::Evicted>(control::Evict{here}).session, here);
}

}  // namespace
}  // namespace feltwire::admin_test
