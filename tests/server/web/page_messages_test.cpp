// Tests the page's messages byte by byte against docs/live_page.md.

#include "server/web/page_messages.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/tool/body_tool.hpp"
#include "tests/server/make.hpp"

namespace feltwire::web::page_messages_test {
namespace {

using Json = nlohmann::json;

/// Reads a binary message from its beginning.
struct Reader {
  const Bytes& bytes;
  std::size_t at = 0;
  template <class Value>
  Value take() {
    Value value;
    EXPECT_LE(at + sizeof value, bytes.size());
    std::memcpy(&value, bytes.data() + at, sizeof value);
    at += sizeof value;
    return value;
  }
  std::uint32_t whole() { return take<std::uint32_t>(); }
  double number() { return static_cast<double>(take<float>()); }
  Vec3 vector() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }
};

TEST(Messages, HelloNamesScenesAndReasons) {
  const std::vector<std::string> scenes = {"room", "a \"b\""};
  const Json hello = Json::parse(web::hello(scenes, Role::observer, false));
  EXPECT_EQ(hello["type"], "hello");
  EXPECT_EQ(hello["scenes"], Json(scenes));
  EXPECT_EQ(hello["role"], "observer");
  EXPECT_EQ(hello["observes"], false);
  EXPECT_EQ(hello["small_debt"], kSmallDebt);
  ASSERT_EQ(hello["reasons"].size(), kHandStates + kHandReasons);
  EXPECT_EQ(hello["reasons"][kHandStates + static_cast<std::size_t>(HandReason::account)]["name"],
            "account");
  EXPECT_EQ(hello["reasons"][static_cast<std::size_t>(HandState::touching)]["name"], "touching");
  EXPECT_EQ(hello["reasons"][static_cast<std::size_t>(HandState::touching)]["cuts"], false);
  EXPECT_EQ(hello["reasons"][static_cast<std::size_t>(HandState::server_bound)]["cuts"], true);
  EXPECT_EQ(hello["reasons"][kHandStates]["cuts"], false);
  for (const Json& reason : hello["reasons"])
    EXPECT_FALSE(reason["text"].get<std::string>().empty());
}

TEST(Messages, ASceneHasItsObjects) {
  Object upside = test::room().objects()[0];
  upside.name = "ceiling";
  upside.pose = {{0, 0, 0.1}, Quaternion(Eigen::AngleAxisd(M_PI, Vec3::UnitX()))};
  const Guide rail{.name = "rail",
                   .place = GuideLine{0.05},
                   .pose = {{0, 0, 0.02}, Quaternion(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitY()))},
                   .action = Attract{.stiffness = 10.0},
                   .max_force = 1.0};
  const Scene scene("room", {test::room().objects()[1], upside}, {}, {rail});
  const Json said = Json::parse(scene_text(scene, 7));
  EXPECT_EQ(said["type"], "scene");
  EXPECT_EQ(said["version"], 7);
  ASSERT_EQ(said["objects"].size(), 2u);
  EXPECT_EQ(said["objects"][0]["name"], "ball");
  EXPECT_EQ(said["objects"][0]["moves"], false);
  EXPECT_FALSE(said["objects"][0].contains("plane"));
  EXPECT_NEAR(said["objects"][1]["plane"]["normal"][2].get<double>(), -1.0, 1e-12);
  EXPECT_EQ(said["guides"][0]["kind"], "attract");
  EXPECT_NEAR(said["guides"][0]["points"][1][0].get<double>(), 0.05, 1e-12);
  // The box contains the ball and a piece of the plane.
  EXPECT_NEAR(said["box"][0][0].get<double>(), -0.2, 1e-9);
  EXPECT_NEAR(said["box"][1][2].get<double>(), 0.1, 1e-9);

  const std::vector<Bytes> shown = geometry(scene, 7);
  ASSERT_EQ(shown.size(), 1u);  // The plane has no mesh.
  Reader reader{shown[0]};
  EXPECT_EQ(reader.whole(), 1u);  // kind of message
  EXPECT_EQ(reader.whole(), 0u);  // object number
  EXPECT_EQ(reader.whole(), 7u);
  const std::uint32_t vertices = reader.whole(), triangles = reader.whole();
  ASSERT_GT(vertices, 100u);
  for (std::uint32_t i = 0; i < vertices; ++i)  // the vertices of the ball in the world frame
    EXPECT_NEAR((reader.vector() - Vec3(0.05, 0, 0.01)).norm(), 0.02, 1e-6);
  for (std::uint32_t i = 0; i < 3 * triangles; ++i) EXPECT_LT(reader.whole(), vertices);
  EXPECT_EQ(reader.at, shown[0].size());
}

TEST(Messages, AGuideOfAShapeHasItsTriangles) {
  const auto guide = [](const char* name, GuidePlace place, const Pose& pose) {
    return Guide{.name = name,
                 .place = std::move(place),
                 .pose = pose,
                 .action = Viscosity{.damping = 1.0},
                 .max_force = 1.0};
  };
  const Guide rail{.name = "line",
                   .place = GuideLine{0.05},
                   .pose = {},
                   .action = Attract{.stiffness = 10.0},
                   .max_force = 1.0};
  const Vec3 middle(0.3, 0, 0.1);
  const Scene scene("room", {test::room().objects()[1]}, {},
                    {guide("ball", Sphere{0.012}, {middle, Quaternion::Identity()}), rail,
                     guide("plane", Plane{}, {{0, 0, -0.3}, Quaternion::Identity()}),
                     guide("all", Everywhere{}, {})});
  const Json said = Json::parse(scene_text(scene, 1));
  const Json& ball = said["guides"][0];
  ASSERT_GT(ball["triangles"].size(), 50u);
  EXPECT_TRUE(ball["points"].empty());
  for (const Json& v : ball["vertices"])
    EXPECT_NEAR((Vec3(v[0].get<double>(), v[1].get<double>(), v[2].get<double>()) - middle).norm(),
                0.012, 2e-6);
  for (const Json& triangle : ball["triangles"])
    for (const Json& corner : triangle)
      EXPECT_LT(corner.get<std::size_t>(), ball["vertices"].size());
  EXPECT_NEAR(said["box"][1][0].get<double>(), 0.312, 1e-6) << "the ball is in the box";
  EXPECT_TRUE(said["guides"][1]["triangles"].empty());
  EXPECT_EQ(said["guides"][2]["triangles"].size(), 2u);  // the square of the plane below the start
  EXPECT_NEAR(said["guides"][2]["vertices"][0][2].get<double>(), -0.3, 1e-9);
  EXPECT_TRUE(said["guides"][3]["triangles"].empty());
}

/// "name" is required, and "name?" is optional.
void expect_members(const Json& said, const Json& members, bool all, const std::string& where) {
  std::vector<std::string> wanted, there;
  for (const Json& entry : members.at(where)) {
    std::string name = entry;
    const bool may = name.ends_with('?');
    if (may) name.pop_back();
    if (!may || all) wanted.push_back(name);
  }
  for (const auto& [name, value] : said.items()) there.push_back(name);
  std::ranges::sort(wanted);
  EXPECT_EQ(there, wanted) << where;
}

/// The page's tests use a mock server in node that reads this file. Page and server therefore agree
/// about the members.
TEST(Messages, HaveTheMembersThatThePageIsTestedWith) {
  std::ifstream file(FELTWIRE_SOURCE_DIR "/tests/web/page/members.json");
  const Json agreed = Json::parse(file);
  const Json& members = agreed["members"];
  Scene scene("room", {test::room().objects()[1], test::room().objects()[0]}, {},
              {Guide{.name = "g",
                     .place = Sphere{0.01},
                     .pose = {},
                     .action = Viscosity{.damping = 1.0},
                     .max_force = 1.0}});
  HandDescription hand;
  const Json greeting = Json::parse(hello({}, Role::observer, false));
  const Json shown = Json::parse(scene_text(scene, 1));
  const Json materials = Json::parse(materials_text(scene, 1, std::nullopt));
  const Json table = Json::parse(sessions({&hand, 1}, {}, {}, 1.0));
  expect_members(greeting, members, true, "hello");
  expect_members(greeting["reasons"][0], members, true, "hello.reasons");
  expect_members(shown, members, true, "scene");
  expect_members(shown["objects"][0], members, false, "scene.objects");
  expect_members(shown["objects"][1], members, true, "scene.objects");
  expect_members(shown["guides"][0], members, true, "scene.guides");
  expect_members(shown["tools"][0], members, true, "scene.tools");
  expect_members(materials, members, true, "materials");
  expect_members(materials["objects"][0], members, true, "materials.objects");
  expect_members(table, members, true, "sessions");
  expect_members(table["sessions"][0], members, true, "sessions.sessions");
  expect_members(Json::parse(ticket_text("room", "fw_t", std::chrono::seconds(60))), members, true,
                 "ticket");
  expect_members(Json::parse(changed_text("a")), members, true, "changed");
  expect_members(Json::parse(web::refused("a")), members, true, "refused");
  expect_members(Json::parse(admin_text()), members, true, "admin");
  const Json recordings = Json::parse(
      recordings_text({"room", "", "", 0.0, 0, control::RecordingEnd::none, {{"a", 1}}}));
  expect_members(recordings, members, true, "recordings");
  expect_members(recordings["kept"][0], members, true, "recordings.kept");
  expect_members(Json::parse(download_text("a", "fw_t")), members, true, "download");
  expect_members(Json::parse(log_text("info", "a")), members, true, "log");
  EXPECT_EQ(greeting["reasons"], agreed["reasons"]);
}

TEST(Messages, APictureHasHandsAndBodies) {
  Picture picture;
  picture.time = from_seconds(12.5);
  picture.version = 3;
  PictureHand hand;
  hand.number = 9;
  hand.states = bit(HandState::touching);
  hand.pose = {{1, 2, 3}, Quaternion(0.5, 0.5, 0.5, 0.5)};
  hand.proxy = {4, 5, 6};
  hand.elastic = {7, 8, 9};
  hand.frictional = {10, 11, 12};
  hand.held = {13, 14, 15};
  hand.depth = 0.25;
  hand.delivered = -0.5;
  hand.burned = 2.0;
  hand.report = HandReport{
      .reasons = bit(HandReason::near), .has_account = true, .balance = 0.75, .round_trip = 0.0625};
  picture.hands = {hand};
  picture.bodies = {{6, {{1, 1, 2}, Quaternion::Identity()}}};
  const std::vector<HandRates> rates = {{8, 1.0, 1.0}, {9, 1000.0, 0.125}};
  const Bytes bytes = web::picture(picture, rates, from_seconds(2.0));

  Reader reader{bytes};
  EXPECT_EQ(reader.whole(), 2u);
  EXPECT_EQ(reader.whole(), 1u);
  EXPECT_EQ(reader.whole(), 1u);
  EXPECT_EQ(reader.whole(), 3u);
  EXPECT_EQ(reader.take<double>(), 10.5);
  const std::size_t begin = reader.at;
  EXPECT_EQ(reader.whole(), 9u);
  EXPECT_EQ(reader.whole(), bit(HandState::touching) | bit(HandReason::near) << kHandStates);
  EXPECT_EQ(reader.vector(), Vec3(1, 2, 3));
  for (int i = 0; i < 4; ++i) EXPECT_EQ(reader.number(), 0.5);
  EXPECT_EQ(reader.vector(), Vec3(4, 5, 6));
  EXPECT_EQ(reader.vector(), Vec3(7, 8, 9));
  EXPECT_EQ(reader.vector(), Vec3(10, 11, 12));
  EXPECT_EQ(reader.vector(), Vec3(13, 14, 15));
  EXPECT_EQ(reader.number(), 0.25);
  EXPECT_EQ(reader.number(), -0.5);
  EXPECT_EQ(reader.number(), 2.0);
  EXPECT_EQ(reader.number(), 0.75);
  EXPECT_EQ(reader.number(), 1000.0);
  EXPECT_EQ(reader.number(), 0.125);
  EXPECT_EQ(reader.number(), 0.0625);
  EXPECT_EQ(reader.at - begin, 112u);
  EXPECT_EQ(reader.whole(), 6u);
  EXPECT_EQ(reader.vector(), Vec3(1, 1, 2));
  EXPECT_EQ(reader.number(), 1.0);
  EXPECT_EQ(reader.at + 12, bytes.size());
}

TEST(Messages, APictureEndsInTheRobot) {
  Picture picture;
  picture.bodies = {{6, {{1, 1, 2}, Quaternion::Identity()}}};
  const std::size_t usual = web::picture(picture, {}, Nanoseconds(0)).size();
  SeenRobot& robot = picture.robots.emplace_back();
  robot.pose = {{1, 2, 3}, Quaternion(0.5, -0.5, 0.5, 0.5)};
  robot.target = {{4, 5, 6}, Quaternion::Identity()};
  robot.force = Vec3(7, 8, 9);
  robot.torque = {10, 11, 12};
  robot.state = LinkState::hold;
  robot.hand = 3;
  robot.stopped = true;
  robot.gripper = 0.25;
  robot.age = 0.125;
  const Bytes bytes = web::picture(picture, {}, Nanoseconds(0));
  ASSERT_EQ(bytes.size(), usual + 100);
  Reader reader{bytes};
  reader.at = usual;
  EXPECT_EQ(reader.whole(), 4u);
  EXPECT_EQ(reader.whole(), 3u);
  EXPECT_EQ(reader.whole(), 7u) << "sensed, well, stopped";
  EXPECT_EQ(reader.vector(), Vec3(1, 2, 3));
  EXPECT_EQ(reader.number(), 0.5);
  EXPECT_EQ(reader.number(), -0.5);
  reader.at += 8;
  EXPECT_EQ(reader.vector(), Vec3(4, 5, 6));
  EXPECT_EQ(reader.number(), 1.0);
  reader.at += 12;
  EXPECT_EQ(reader.vector(), Vec3(7, 8, 9));
  EXPECT_EQ(reader.vector(), Vec3(10, 11, 12));
  EXPECT_EQ(reader.number(), 0.25);
  EXPECT_EQ(reader.number(), 0.125);
  EXPECT_EQ(reader.at, bytes.size());
}

TEST(Messages, ASceneHasItsTools) {
  Scene scene("room", test::room().objects(), {}, {});
  scene.set_tools({{.radius = 0.004, .body = nullptr, .name = "ball"},
                   {.radius = 0.0, .body = nullptr, .name = "tip"}});
  Json tools = Json::parse(scene_text(scene, 1))["tools"];
  ASSERT_EQ(tools.size(), 2u);
  EXPECT_EQ(tools[0]["name"], "ball");
  EXPECT_EQ(tools[0]["radius"], 0.004);
  EXPECT_EQ(tools[1]["radius"], 0.0);
  EXPECT_TRUE(tools[1]["points"].empty());

  // A cube of 20 mm. The message has some of its 3000 points.
  constexpr double kHalf = 0.01;
  const TriangleSoup cube = Box{Vec3::Constant(kHalf)}.triangles(1);
  scene.set_tool(
      {.body = std::make_shared<BodyTool>(point_shell(cube, 3000), ToolCoupling{}, 0.0)});
  tools = Json::parse(scene_text(scene, 2))["tools"];
  ASSERT_EQ(tools.size(), 1u);
  ASSERT_GT(tools[0]["points"].size(), 300u);
  EXPECT_LE(tools[0]["points"].size(), 400u);
  for (const Json& point : tools[0]["points"]) {
    const Vec3 place(point[0].get<double>(), point[1].get<double>(), point[2].get<double>());
    EXPECT_NEAR(place.cwiseAbs().maxCoeff(), kHalf, 1e-9);
  }
}

TEST(Messages, SurfacesAreThoseOfEachHand) {
  Picture picture;
  picture.version = 3;
  picture.hands.resize(3);
  EXPECT_TRUE(surfaces(picture).empty());
  picture.hands[1].number = 5;
  LocalModel& model = picture.hands[1].surfaces;
  model.reach = 0.5;
  model.count = 2;
  SurfacePatch& patch = model.patches[0];
  patch.point = {1, 2, 3};
  patch.normal = {0, 1, 0};
  patch.axis = {1, 0, 0};
  patch.curvature = 4.0;
  patch.radius = 0.25;
  patch.offset = 0.125;
  model.patches[1].touching = model.patches[1].slipping = true;
  const Bytes bytes = surfaces(picture);

  Reader reader{bytes};
  EXPECT_EQ(reader.whole(), 3u);  // kind of message
  EXPECT_EQ(reader.whole(), 3u);
  EXPECT_EQ(reader.whole(), 2u);
  EXPECT_EQ(reader.whole(), 5u);
  EXPECT_EQ(reader.whole(), 0u);
  EXPECT_EQ(reader.vector(), Vec3(1, 2, 3));
  EXPECT_EQ(reader.vector(), Vec3(0, 1, 0));
  EXPECT_EQ(reader.vector(), Vec3(1, 0, 0));
  EXPECT_EQ(reader.number(), 4.0);
  EXPECT_EQ(reader.number(), 0.25);
  EXPECT_EQ(reader.number(), 0.5);
  EXPECT_EQ(reader.number(), 0.125);
  EXPECT_EQ(reader.whole(), 5u);
  EXPECT_EQ(reader.whole(), 3u);
  EXPECT_EQ(bytes.size(), 12u + 2u * 60u);
}

TEST(Messages, SessionsSayWhatTheyAskedFor) {
  HandDescription hand;
  hand.number = 2;
  hand.session = (std::uint64_t{1} << 63) + 1;  // too large for a JavaScript number
  hand.client = "anna\n";
  hand.parameters.emplace().packet_interval = 4;
  const Json said = Json::parse(sessions({&hand, 1}, {}, {}, 1.5));
  EXPECT_EQ(said["time"], 1.5);
  const Json& entry = said["sessions"][0];
  EXPECT_EQ(entry["session"], "9223372036854775809");
  EXPECT_EQ(entry["client"], "anna\n");
  EXPECT_EQ(entry["packet_hz"], 250.0);
  EXPECT_TRUE(entry["loss"].is_null());
  EXPECT_TRUE(entry["late_ticks"].is_null());
  EXPECT_TRUE(entry["wakeups"].is_null());
}

TEST(Messages, SessionsSayHowPunctualTheyAre) {
  HandDescription hand;
  hand.times.take(HandTimes{});
  HandTimes said;
  said.wakeups[0] = 990;
  said.wakeups[7] = 2;
  said.round_trips[1] = 500;
  hand.times.take(said);
  const Json entry = Json::parse(sessions({&hand, 1}, {}, {}, 1.5))["sessions"][0];
  EXPECT_EQ(entry["wakeups"], Json({990, 0, 0, 0, 0, 0, 0, 2}));
  EXPECT_EQ(entry["round_trips"], Json({0, 500, 0, 0, 0, 0, 0, 0}));
  const Json said_first = Json::parse(hello({}, Role::observer, false));
  EXPECT_EQ(said_first["wakeup_limits"].size(), 7u);
  EXPECT_EQ(said_first["wakeup_limits"][0], 2e-5);
  EXPECT_EQ(said_first["round_trip_limits"][6], 0.1);
}

/// A gateway lacks some values.
TEST(Messages, SessionsSayWhatIsNotKnown) {
  HandDescription hand;
  hand.number = 2;
  Picture picture;
  picture.hands.emplace_back();
  picture.hands[0].number = 2;
  picture.hands[0].report = HandReport{.late_ticks = 12};
  picture.time = from_seconds(8.0);
  const Json said = Json::parse(sessions({&hand, 1}, picture, {}, 1.5));
  const Json& entry = said["sessions"][0];
  for (const char* unknown :
       {"client", "device", "mode", "side", "local_model", "rate_hz", "packet_hz"})
    EXPECT_TRUE(entry[unknown].is_null()) << unknown;
  EXPECT_EQ(entry["late_ticks"], 12);
  EXPECT_TRUE(entry["seconds"].is_null());
  EXPECT_TRUE(entry["hand_damping"].is_null());
  hand.joined = from_seconds(5.5);
  picture.hands[0].report->hand_damping = 1.5;
  const Json known = Json::parse(sessions({&hand, 1}, picture, {}, 1.5))["sessions"][0];
  EXPECT_EQ(known["seconds"], 2.5);
  EXPECT_EQ(known["hand_damping"], 1.5);
}

}  // namespace
}  // namespace feltwire::web::page_messages_test
