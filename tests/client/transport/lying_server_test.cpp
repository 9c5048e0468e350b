// A server lies or answers without end. The client must limit its requests and its memory, and name
// the reason.

#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "client/app/admin_requests.hpp"
#include "client/transport/fetch_room.hpp"
#include "client/transport/listing.hpp"
#include "client/transport/scene_fetch.hpp"
#include "tests/client/answering_peer.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/core/heavy_geometry.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::lying_server_test {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using testing::AnsweringPeer;
using testing::error_of;
using ::testing::Gt;
using ::testing::HasSubstr;
using ::testing::Lt;

constexpr std::uint64_t kSession = 7;

/// Returns a part with distinct points.
control::SurfacePart part(std::size_t vertices, std::size_t triangles) {
  control::SurfacePart made;
  for (std::size_t i = 0; i < vertices; ++i)
    made.vertices.emplace_back(0.1 * static_cast<double>(i % 2), 0.1 * static_cast<double>(i / 2),
                               1e-4 * static_cast<double>(i * i));
  made.triangles.assign(triangles, {0, 1, 2});
  return made;
}

control::SurfaceEntry surface(std::uint16_t object, std::uint32_t vertices,
                              std::uint32_t triangles) {
  control::SurfaceEntry entry{.surface = {}, .vertices = vertices, .triangles = triangles};
  entry.surface.object = object;
  return entry;
}

control::SolidEntry solid(std::uint16_t object) {
  control::SolidEntry entry{.solid = {}, .vertices = 4, .triangles = 4};
  entry.solid.object = object;
  entry.solid.material.stiffness = 1000.0;
  return entry;
}

/// The mesh of such a solid: a corner of a cube.
control::SurfacePart tetrahedron() {
  control::SurfacePart made;
  made.vertices = {{0, 0, 0}, {0, 0, 0.1}, {0, 0.1, 0}, {0.1, 0, 0}};
  made.triangles = {{0, 2, 3}, {0, 3, 1}, {0, 1, 2}, {3, 2, 1}};
  return made;
}

/// The geometry that a server offers, and its answers to requests for parts.
struct Offer {
  control::SurfaceList surfaces{.version = 1, .surfaces = {}};
  control::SolidList solids{.version = 1};
  control::SurfacePart part{};
  control::BodyPoints points{};

  control::Message operator()(const control::Message& question) const {
    if (std::holds_alternative<control::ListSurfaces>(question)) return surfaces;
    if (std::holds_alternative<control::ListSolids>(question)) return solids;
    if (std::holds_alternative<control::GetSurface>(question)) return part;
    if (std::holds_alternative<control::GetBodyPoints>(question)) return points;
    return control::SurfacesTaken{kSession};
  }
};

/// Returns the peak of the heap [bytes] during `work`, minus the heap before. The test's server
/// runs in this process.
template <class Work>
std::size_t taken_by(const char* name, const AnsweringPeer& peer, Work work) {
  const std::size_t before = test::heap_held();
  test::begin_heap_peak();
  work();
  const std::size_t most = test::heap_peak() - before;
  std::printf("%-34s %6.1f MB, %zu questions\n", name, 1e-6 * static_cast<double>(most),
              peer.questions().size());
  return most;
}

/// [bytes] that the sampling of one grid takes besides the grid.
constexpr std::size_t kMostOfSampling = 32'000'000;

class FetchAttack : public ::testing::Test {
 protected:
  /// Sends a due request and takes the result. The clock advances by an hour, so the fetch never
  /// waits.
  void ask(SceneFetch& fetch, const ScenePlace& place = {kSession, 0}) {
    fetch.look(place, now_ += 1h);
    test::eventually("the end of the questions", [&] {
      fetch.look({}, now_);
      return !fetch.asking();
    });
  }
  /// Fetches, and expects exactly this number of requests for parts.
  void expect_refused(const Offer& offer, std::size_t parts, const std::string& reason) {
    AnsweringPeer peer(offer);
    SceneFetch fetch(peer.access(), ready_, {.timeout = 5s});
    ask(fetch);
    const auto asked = [&] {
      return peer.of_kind<control::GetSurface>().size() +
             peer.of_kind<control::GetBodyPoints>().size();
    };
    EXPECT_EQ(asked(), parts);
    EXPECT_THAT(fetch.refusal(), HasSubstr(reason));
    const std::size_t questions = peer.questions().size();
    for (int i = 0; i < 3; ++i) ask(fetch);
    EXPECT_EQ(peer.questions().size(), questions);
    const FetchedScene* none = nullptr;
    EXPECT_FALSE(ready_.pop(none));
  }

  Ring<const FetchedScene*> ready_{4};
  SceneFetch::Clock::time_point now_{};
};

TEST_F(FetchAttack, AMeshThatNeverEndsIsNotFetched) {
  struct Lie {
    control::SurfacePart part;
    std::size_t parts;  // number of requests for parts
    const char* reason;
  };
  for (const Lie& lie : {Lie{part(1, 0), 4, "more vertices of object 3 than the 3"},
                         Lie{part(0, 1), 2, "more triangles of object 3 than the 1"},
                         Lie{part(1200, 0), 1, "more vertices of object 3 than the 3"},
                         Lie{part(3, 2), 1, "more triangles of object 3 than the 1"},
                         Lie{part(0, 0), 1, "an empty part of object 3"}}) {
    Offer offer;
    offer.surfaces.surfaces = {surface(3, 3, 1)};
    offer.part = lie.part;
    expect_refused(offer, lie.parts, lie.reason);
  }
}

TEST_F(FetchAttack, ABodyThatNeverEndsIsNotFetched) {
  Offer offer;
  offer.solids.body.emplace();
  offer.solids.points = 5;
  expect_refused(offer, 1, "an empty part of the tool");
  offer.points.points.assign(1200, Vec3::Zero());
  expect_refused(offer, 1, "more points of the tool than the 5");
}

TEST_F(FetchAttack, AnObjectThatIsListedTwiceIsNotFetched) {
  Offer offer;
  offer.surfaces.surfaces = {surface(3, 3, 1), surface(3, 3, 1)};
  offer.part = part(3, 1);
  expect_refused(offer, 1, "object 3 of the scene twice");
}

TEST_F(FetchAttack, ASceneThatCannotBeIsNotFetchedAgain) {
  Offer offer;
  offer.surfaces.surfaces = {surface(3, 3, 2)};
  offer.part = part(3, 2);  // Both triangles have equal corners.
  expect_refused(offer, 1, "sent a scene that cannot be: the surface of object 3");
}

/// The client must not request announced geometry that is too large for its limits.
TEST_F(FetchAttack, AnnouncedCountsTakeNoMemory) {
  constexpr std::uint32_t kAll = 0xFFFFFFFF, kMost = FetchRoom::kMostTriangles;
  for (const auto& [vertices, triangles] : {std::pair{kAll, kAll}, std::pair{3u, kMost + 1},
                                            std::pair{3 * kMost + 1, kMost}, std::pair{4u, 1u}}) {
    Offer offer;
    offer.surfaces.surfaces = {surface(0, vertices, triangles)};
    AnsweringPeer peer(offer);
    SceneFetch fetch(peer.access(), ready_, {.timeout = 5s});
    ask(fetch);
    EXPECT_EQ(peer.questions().size(), 1u);
    EXPECT_FALSE(fetch.asking());
  }
  Offer offer;
  offer.solids.body.emplace();
  offer.solids.points = kAll;
  AnsweringPeer peer(offer);
  SceneFetch fetch(peer.access(), ready_, {.timeout = 5s});
  ask(fetch);
  EXPECT_TRUE(peer.of_kind<control::GetBodyPoints>().empty());
}

/// The grid of four triangles is as large as the grid of four thousand.
TEST_F(FetchAttack, GridsOfManySmallMeshesHaveABound) {
  constexpr std::uint16_t kMeshes = 100;
  Offer offer;
  BodyData ball = test::ball_of_points(50);
  offer.points.points = std::exchange(ball.points, {});
  offer.solids.body = ball;
  offer.solids.points = static_cast<std::uint32_t>(offer.points.points.size());
  for (std::uint16_t i = 0; i < kMeshes; ++i) offer.solids.solids.push_back(solid(i));
  offer.part = tetrahedron();
  AnsweringPeer peer(offer);
  SceneFetch fetch(peer.access(), ready_, {.timeout = 5s, .clock = [] { return Nanoseconds(0); }});
  [[maybe_unused]] const std::size_t most =
      taken_by("grids of 100 solids", peer, [&] { ask(fetch); });
  std::set<std::uint16_t> objects;
  for (const auto& asked : peer.of_kind<control::GetSurface>()) objects.insert(asked.object);
  EXPECT_EQ(objects.size(), FetchRoom::kMostGrids);
  const FetchedScene* fetched = nullptr;
  ASSERT_TRUE(ready_.pop(fetched)) << fetch.refusal();
  // Some grids fit, and the others are left out of the list that the server gets.
  EXPECT_THAT(fetched->objects.size(), AllOf(Gt(1u), Lt(std::size_t{FetchRoom::kMostGrids})));
#ifndef FELTWIRE_SANITIZED
  EXPECT_LT(most, FetchRoom::kMostGridBytes + kMostOfSampling);
#endif
}

/// The client keeps scenes that the servo does not use yet. A server that sends a new scene with
/// each answer must not fill the memory.
TEST_F(FetchAttack, ScenesThatAreHeldHaveABound) {
  std::uint32_t version = 0;
  AnsweringPeer peer([&version](const control::Message& question) -> control::Message {
    Offer offer;
    offer.surfaces = {.version = ++version, .surfaces = {surface(0, 3, 1)}};
    offer.part = part(3, 1);
    return offer(question);
  });
  SceneFetch fetch(peer.access(), ready_, {.timeout = 5s});
  const FetchedScene* newest = nullptr;
  const auto fetched = [&](int times) {
    std::size_t count = 0;
    for (int i = 0; i < times; ++i) {
      ask(fetch);
      while (ready_.pop(newest)) ++count;
    }
    return count;
  };
  EXPECT_EQ(fetched(10), SceneFetch::kMostKept);
  EXPECT_EQ(peer.of_kind<control::GetSurface>().size(), SceneFetch::kMostKept);
  fetch.in_use(newest);
  EXPECT_EQ(fetched(10), 1u);
}

/// An honest server with a wavy surface of the largest size that a client fetches.
class HonestServer {
 public:
  HonestServer() {
    for (std::uint32_t i = 0; i < kSide; ++i)
      for (std::uint32_t j = 0; j < kSide; ++j)
        vertices_.emplace_back(1e-3 * i, 1e-3 * j, 1e-3 * std::sin(0.1 * (i + 2.0 * j)));
    for (std::uint32_t i = 0; i + 1 < kSide; ++i)
      for (std::uint32_t j = 0; j + 1 < kSide; ++j) {
        const std::uint32_t here = i * kSide + j;
        triangles_.push_back({here, here + kSide, here + 1});
        triangles_.push_back({here + 1, here + kSide, here + kSide + 1});
      }
  }
  control::Message operator()(const control::Message& question) const {
    Offer offer;
    offer.surfaces.surfaces = {surface(0, static_cast<std::uint32_t>(vertices_.size()),
                                       static_cast<std::uint32_t>(triangles_.size()))};
    if (const auto* get = std::get_if<control::GetSurface>(&question)) {
      offer.part.vertices = part_of(vertices_, get->vertices);
      offer.part.triangles = part_of(triangles_, get->triangles);
    }
    return offer(question);
  }

 private:
  static constexpr std::uint32_t kSide = 317;
  static_assert(2 * (kSide - 1) * (kSide - 1) <= FetchRoom::kMostTriangles &&
                2 * kSide * kSide > FetchRoom::kMostTriangles);
  template <class Entry>
  static std::vector<Entry> part_of(const std::vector<Entry>& all, std::size_t from) {
    from = std::min(from, all.size());
    const std::size_t to = std::min(from + control::kMaxPart, all.size());
    return {all.begin() + static_cast<std::ptrdiff_t>(from),
            all.begin() + static_cast<std::ptrdiff_t>(to)};
  }
  std::vector<Vec3> vertices_;
  std::vector<Triangle> triangles_;
};

/// A server that announces a surface of the largest size, and sends parts of these sizes.
AnsweringPeer::Answer endless(std::size_t vertices, std::size_t triangles) {
  Offer offer;
  offer.surfaces.surfaces = {surface(0, 3 * FetchRoom::kMostTriangles, FetchRoom::kMostTriangles)};
  offer.part = part(vertices, triangles);
  return offer;
}

AnsweringPeer::Answer endless_points() {
  Offer offer;
  offer.solids.body.emplace();
  offer.solids.points = kMostBodyPoints;
  offer.points.points.assign(control::kMaxPart, Vec3::Zero());
  return offer;
}

/// The largest allowed number of surfaces. Each has an equal share of the limit.
AnsweringPeer::Answer many_surfaces() {
  constexpr std::uint32_t kEach = FetchRoom::kMostTriangles / control::kMaxSurfaces;
  Offer offer;
  for (std::uint16_t i = 0; i < control::kMaxSurfaces; ++i)
    offer.surfaces.surfaces.push_back(surface(i, 3 * kEach, kEach));
  offer.part = part(100, 0);
  return offer;
}

TEST_F(FetchAttack, NoLieTakesMuchMoreMemoryThanAnHonestSurface) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "a sanitizer has an allocator of its own";
#endif
  const auto taken = [&](const char* name, const AnsweringPeer::Answer& server) {
    AnsweringPeer peer(server);
    SceneFetch fetch(peer.access(), ready_,
                     {.timeout = 5s, .clock = [] { return Nanoseconds(0); }});
    const std::size_t most = taken_by(name, peer, [&] { ask(fetch); });
    const FetchedScene* fetched = nullptr;
    while (ready_.pop(fetched)) {
    }
    return most;
  };
  const std::size_t usual = taken("an honest surface", HonestServer());
  const auto below = [&](double most) { return Lt(most * static_cast<double>(usual)); };
  EXPECT_THAT(taken("vertices without end", endless(control::kMaxPart, 0)), below(1.0));
  EXPECT_THAT(taken("triangles without end", endless(0, control::kMaxPart)), below(1.0));
  EXPECT_THAT(taken("a hundred vertices of 200 surfaces", many_surfaces()), below(1.0));
  EXPECT_THAT(taken("points without end", endless_points()), below(1.0));
  // This surface is complete, with the largest number of vertices for its triangles.
  EXPECT_THAT(taken("all triangles on the same corners", endless(control::kMaxPart, 400)),
              below(1.5));
}

control::SessionDescription session(std::uint32_t number) {
  control::SessionDescription described;
  described.number = number;
  described.changes.asked.assign(4000, 'x');
  return described;
}

std::string refusal_of_sessions(const AnsweringPeer& peer) {
  return error_of<FalseAnswer>([&] { sessions_of(peer.access(), "floor"); });
}

TEST(LyingLists, SessionsWithoutEndAreNotKept) {
  constexpr std::uint32_t kOfOne = 14;
  AnsweringPeer peer([](const control::Message& question) -> control::Message {
    control::SessionDescriptions list{.sessions = {}, .more = true};
    const std::uint32_t after = std::get<control::DescribeSessions>(question).after;
    for (std::uint32_t i = 1; i <= kOfOne; ++i) list.sessions.push_back(session(after + i));
    return list;
  });
  EXPECT_THAT(refusal_of_sessions(peer),
              HasSubstr("listed sessions of more than 2097152 bytes, those of scene 'floor'"));
  EXPECT_LE(peer.questions().size(), kRoomOfServer / (kOfOne * std::size_t{4000}) + 1);
}

/// The program takes some 14 MB without the lists. With the lists it must take less than 1.5 times
/// as much.
constexpr std::size_t kMostOfLists = 5'000'000;  // [bytes]

TEST(LyingLists, SessionsWithoutEndTakeLittleMemory) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "a sanitizer has an allocator of its own";
#endif
  for (const std::size_t text : {0, 30, 4000}) {
    AnsweringPeer peer([text](const control::Message& question) -> control::Message {
      control::SessionDescriptions list{.sessions = {}, .more = true};
      const std::uint32_t after = std::get<control::DescribeSessions>(question).after;
      const std::uint32_t many = text > 1000 ? 14 : control::kMaxDescriptions;
      for (std::uint32_t i = 1; i <= many; ++i) {
        list.sessions.push_back(session(after + i));
        list.sessions.back().changes.asked.resize(text);
      }
      return list;
    });
    const auto most = taken_by(("sessions, texts of " + std::to_string(text)).c_str(), peer, [&] {
      EXPECT_THAT(refusal_of_sessions(peer), HasSubstr("listed sessions of"));
    });
    EXPECT_LT(most, kMostOfLists);
  }
}

/// The program prints the largest possible number of sessions.
TEST(LyingLists, AsManySessionsAsHaveRoomArePrintedInLittleMemory) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "a sanitizer has an allocator of its own";
#endif
  SeenSessions seen;
  for (std::size_t i = 0; i < kRoomOfServer / sizeof(control::SessionDescription); ++i)
    seen.push_back({"floor", {}});
  const std::size_t before = test::heap_held();
  test::begin_heap_peak();
  std::size_t written = 0;
  write_session_json(seen, [&](std::string_view piece) { written += piece.size(); });
  EXPECT_GT(written, 500'000u);
  EXPECT_LT(test::heap_peak() - before, kMostOfLists);
  test::begin_heap_peak();
  EXPECT_GT(session_table(seen).size(), 100'000u);
  EXPECT_LT(test::heap_peak() - before, kMostOfLists);
}

TEST(LyingLists, SessionsAreOneDocument) {
  const auto text_of = [](const SeenSessions& sessions) {
    std::string text;
    write_session_json(sessions, [&](std::string_view piece) { text += piece; });
    return text;
  };
  EXPECT_EQ(text_of({}), "[]\n");
  const std::string text =
      text_of({{"floor", session(1)}, {"floor", session(2)}, {"wall", session(3)}});
  const auto document = nlohmann::ordered_json::parse(text);
  EXPECT_EQ(document.dump(2) + "\n", text);
  ASSERT_EQ(document.size(), 3u);
  EXPECT_EQ(document[2]["scene"], "wall");
  EXPECT_EQ(document[2]["number"], 3);
}

TEST(LyingLists, CountersWithoutEndAreNotKept) {
  constexpr std::size_t kOfOne = 200;
  AnsweringPeer peer([](const control::Message& question) -> control::Message {
    if (std::holds_alternative<control::ListScenes>(question)) {
      control::SceneList list;
      for (std::size_t i = 0; i < control::kMaxScenes; ++i)
        list.scenes.push_back({"scene" + std::to_string(i), 1, 0, 0});
      return list;
    }
    return control::Counters{std::vector<control::Counter>(kOfOne, {std::string(100, 'c'), 1})};
  });
  EXPECT_THAT(error_of<FalseAnswer>([&] { counters_of(peer.access()); }),
              HasSubstr("told counters of more than 1048576 bytes"));
  EXPECT_LE(peer.of_kind<control::GetCounters>().size(),
            kRoomOfCounters / (kOfOne * sizeof(control::Counter)) + 1);
}

TEST(LyingLists, AListThatBringsNothingNewEnds) {
  AnsweringPeer empty([](const control::Message&) -> control::Message {
    return control::SessionDescriptions{.sessions = {}, .more = true};
  });
  EXPECT_THAT(refusal_of_sessions(empty), HasSubstr("there are more sessions"));
  EXPECT_EQ(empty.questions().size(), 1u);
  AnsweringPeer same([](const control::Message&) -> control::Message {
    return control::SessionDescriptions{.sessions = {session(5), session(6)}, .more = true};
  });
  EXPECT_THAT(refusal_of_sessions(same), HasSubstr("not by rising number"));
  EXPECT_EQ(same.questions().size(), 2u);
}

TEST(LyingLists, MoreScenesThanAServerHasAreNone) {
  control::SceneList list;
  for (std::size_t i = 0; i <= control::kMaxScenes; ++i)
    list.scenes.push_back({"scene" + std::to_string(i), 1, 0, 0});
  AnsweringPeer peer([&](const control::Message&) -> control::Message { return list; });
  EXPECT_THAT(error_of<FalseAnswer>([&] { list_scenes(peer.access(), 5s); }),
              HasSubstr("listed 257 scenes"));
}

/// A server with a scene that grows with each answer. The server describes `materials` objects at a
/// time.
struct Described {
  std::uint32_t objects, more_objects;
  std::size_t materials;
  control::Message operator()(const control::Message& question) const {
    const std::uint32_t from = std::get<control::DescribeScene>(question).from;
    return control::SceneDescription{.version = 1,
                                     .gravity = {},
                                     .objects = objects + more_objects * from,
                                     .materials = std::vector<Material>(materials)};
  }
};

TEST(LyingLists, MaterialsWithoutEndAreNotKept) {
  struct Case {
    Described server;
    std::size_t asked, got;
    const char* reason;
  };
  for (const Case& c : {Case{{3, 0, 1}, 3, 3, ""},        // honest, one material at a time
                        Case{{1000, 1, 1000}, 1, 0, ""},  // another number of objects
                        Case{{3, 1, 1}, 2, 0, ""},        // a growing scene
                        Case{{3, 0, 4}, 1, 0, "described 4 materials"},
                        Case{{3, 0, 2}, 2, 0, "described 2 materials of scene 'floor', where 1"},
                        Case{{3, 0, 0}, 1, 0, "described 0 materials"}}) {
    AnsweringPeer peer(c.server);
    std::size_t got = 0;
    const auto describe = [&] {
      ControlDialogue dialogue(peer.access(), 5s);
      got = described_materials(dialogue, "floor", 3).materials.size();
    };
    if (*c.reason == '\0')
      describe();
    else
      EXPECT_THAT(error_of<FalseAnswer>(describe), HasSubstr(c.reason));
    EXPECT_EQ(got, c.got);
    EXPECT_EQ(peer.questions().size(), c.asked);
  }
}

}  // namespace
}  // namespace feltwire::lying_server_test
