#include "tests/core/script.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <ostream>

namespace feltwire::test {
namespace {

/// Parameters of a script's hand. If the hand moves much by itself, the device dissipates so much
/// that a loss would not show.
struct Temper {
  // probability of the worst movement; other movements range over 10^-8 to 10^farthest [m]
  double greed, farthest;
};

Tick random_tick(Random& random, const ScriptOptions& o, const Temper& temper) {
  Tick t;
  if (random.chance(temper.greed)) {
    constexpr Hand kGreedy[] = {Hand::takes, Hand::takes, Hand::takes_along, Hand::takes_across};
    t.hand = kGreedy[static_cast<int>(random.uniform(0, 4))];
    if (random.chance(0.5)) t.share = random.uniform(-4.0, 3.0);
  } else if (random.chance(0.3)) {
    t.hand = Hand::trembles;
  }
  if (t.hand == Hand::wanders ? random.chance(0.9) : random.chance(0.3)) {
    t.displacement = random.vector(-8.0, temper.farthest);
    t.rotation = random.vector(-8.0, temper.farthest + 1.0);
  }
  t.wall = random.chance(0.3);
  if (!t.wall) {
    t.command = random_command(random);
    // The largest value of random_command() is 1e3 N.
    const double beyond = std::pow(10.0, o.largest - 3.0);
    if (beyond < 1.0) t.command = beyond * t.command;
  }
  if (random.chance(0.3)) t.age = static_cast<int>(random.uniform(0.0, 30.0));
  if (random.chance(0.3)) t.hold = random.uniform(0.2, 1.0);
  if (o.longest_hold > 1.0 && random.chance(0.1)) t.hold = random.uniform(1.0, o.longest_hold);
  if (o.reduces && random.chance(0.3)) t.kept = random.uniform(0.0, 1.0);
  if (o.bends && random.chance(0.1)) t.bent = random.direction();
  t.skipped = o.skips && random.chance(0.1);
  t.lost = o.loses && random.chance(0.05);
  if (o.laws > 1 && random.chance(0.05)) t.law = static_cast<int>(random.uniform(0.0, o.laws));
  return t;
}

/// Returns v with each component rounded to one digit.
Vec3 rounded(Vec3 v) {
  for (double& x : v) {
    if (x == 0.0) continue;
    const double unit = std::pow(10.0, std::floor(std::log10(std::abs(x))));
    x = std::round(x / unit) * unit;
  }
  return v;
}

/// Returns copies of the tick. Each copy has one simplified element.
rc::Seq<Tick> simpler(const Tick& tick) {
  std::vector<Tick> all;
  const auto with = [&](auto change) {
    Tick t = tick;
    change(t);
    if (t != tick) all.push_back(t);
  };
  with([](Tick& t) { t = {}; });
  with([](Tick& t) { t.displacement.setZero(); });
  with([](Tick& t) { t.rotation.setZero(); });
  with([](Tick& t) { t.hand = Hand::wanders; });
  with([](Tick& t) { t.share = 1.0; });
  with([](Tick& t) { t.wall = false; });
  with([](Tick& t) { t.command.elastic.setZero(); });
  with([](Tick& t) { t.command.frictional.setZero(); });
  with([](Tick& t) { t.command.torque.setZero(); });
  with([](Tick& t) { t.age = 0; });
  with([](Tick& t) { t.hold = 1.0; });
  with([](Tick& t) { t.kept = 1.0; });
  with([](Tick& t) { t.bent.setZero(); });
  with([](Tick& t) { t.skipped = t.lost = false; });
  with([](Tick& t) { t.law = -1; });
  with([](Tick& t) {
    for (Vec3* v : {&t.displacement, &t.rotation, &t.command.elastic, &t.command.frictional,
                    &t.command.torque})
      *v = rounded(*v);
  });
  return rc::seq::fromContainer(all);
}

rc::Seq<Script> shorter_or_simpler(const Script& script) {
  const auto with_ticks = [script](std::vector<Tick>&& ticks) {
    Script s = script;
    s.ticks = std::move(ticks);
    return s;
  };
  return rc::seq::concat(rc::seq::map(rc::shrink::removeChunks(script.ticks), with_ticks),
                         rc::seq::map(rc::shrink::eachElement(script.ticks, simpler), with_ticks));
}

Mat3 orientation(Random& random) {
  return Eigen::AngleAxisd(random.uniform(0.0, 3.14), random.direction()).toRotationMatrix();
}

void show(std::ostream& out, const char* what, const Vec3& v) {
  if (!v.isZero(0)) out << ' ' << what << " (" << v.x() << ", " << v.y() << ", " << v.z() << ')';
}

}  // namespace

rc::Gen<Script> scripts(const ScriptOptions& options) {
  return [options](const rc::Random& seed, int) {
    Random random(rc::Random(seed).next());
    Script script;
    script.stiffness = std::abs(random.decades(0.0, 5.0));
    script.friction = random.chance(0.5) ? random.uniform(0.0, 1.5) : 0.0;
    script.tremble = std::abs(random.decades(-7.0, -3.0));
    const Temper temper{options.greedy ? random.uniform(0.0, 1.0) : 0.0,
                        random.uniform(-7.0, -2.0)};
    const int ticks = static_cast<int>(random.uniform(2.0, options.longest));
    for (int n = 0; n < ticks; ++n) script.ticks.push_back(random_tick(random, options, temper));
    return rc::shrinkable::shrinkRecur(std::move(script),
                                       [](const Script& s) { return shorter_or_simpler(s); });
  };
}

rc::Gen<Mat3> random_damping(double b, double condition) {
  return [=](const rc::Random& seed, int) {
    Random random(rc::Random(seed).next());
    const Mat3 axes = orientation(random);
    const double worst = std::pow(condition, random.uniform(0.0, 1.0));
    const Vec3 along(1.0, std::pow(worst, -random.uniform(0.0, 1.0)), 1.0 / worst);
    const Mat3 raw = b * axes * along.asDiagonal() * axes.transpose();
    return rc::shrinkable::just(Mat3(0.5 * (raw + raw.transpose())));
  };
}

rc::Gen<Mat3> random_orientation() {
  return [](const rc::Random& seed, int) {
    Random random(rc::Random(seed).next());
    return rc::shrinkable::just(orientation(random));
  };
}

void showValue(const Script& script, std::ostream& out) {
  constexpr const char* kHands[] = {"wanders", "takes", "takes along", "takes across", "trembles"};
  out << "wall " << script.stiffness << " N/m, friction " << script.friction << ", tremble "
      << script.tremble << " m\n";
  for (const Tick& t : script.ticks) {
    out << kHands[static_cast<int>(t.hand)] << " x " << t.share;
    show(out, "moves", t.displacement);
    show(out, "turns", t.rotation);
    if (t.wall) out << " | the wall answers";
    show(out, "| elastic", t.command.elastic);
    show(out, "frictional", t.command.frictional);
    show(out, "torque", t.command.torque);
    if (t.age > 0) out << " | " << t.age << " ticks old";
    if (t.hold != 1.0) out << " | after " << t.hold << " T";
    if (t.kept != 1.0) out << " | keeps " << t.kept;
    show(out, "| bends it to", t.bent);
    if (t.skipped) out << " | skips the write";
    if (t.lost) out << " | movement lost";
    if (t.law >= 0) out << " | law " << t.law;
    out << '\n';
  }
}

}  // namespace feltwire::test
