// The damping may depend on the direction. The properties of a scalar damping must hold for a
// matrix, in the metric of its inverse.

#include <cmath>

#include "tests/core/play.hpp"

namespace feltwire::damping_properties_test {
namespace {

using namespace test;

constexpr double kWorstCondition = 1e4;

/// Four variants of the contact frame, and the energy tank.
constexpr int kLaws = 5;
BoundingConfig law_of(int which, const Damping& damping, const Damping& rotational) {
  BoundingConfig c = config("contact_frame");
  c.projection = which % 2 ? Projection::cone : Projection::joint;
  c.storage = which / 2 % 2 ? Storage::elastic : Storage::minimal;
  if (which == 4) c.mode = "energy_tank";
  c.damping = damping;
  c.rotational_damping = rotational;
  return c;
}
int random_law() { return *rc::gen::inRange(0, kLaws); }
Port random_port() {
  return {Damping(*random_damping(0.5, kWorstCondition)),
          Damping(*random_damping(1e-3, kWorstCondition))};
}
double condition(const Port& port) {
  return std::max(port.damping.matrix().trace() / port.damping.least(),
                  port.rotational_damping.matrix().trace() / port.rotational_damping.least());
}

template <class Real>
void never_more_than_burned(const Script& script, const BoundingConfig& law, const Port& port) {
  Margin margin{port};
  const double c = condition(port);
  play<Real>(script, {law}, port, [&](const Played<Real>& p, const auto&) {
    margin.account(p);
    RC_ASSERT(margin.kept<Real>(c));
  });
}

// The device must not rotate forces here. In a direction with less damping, a force gives more
// energy.
RC_GTEST_PROP(DampingProperty, DeliveredIsNeverMoreThanBurned, ()) {
  const int which = random_law();
  const Port port = random_port();
  const Script script = *scripts({.reduces = true});
  never_more_than_burned<double>(script, law_of(which, port.damping, port.rotational_damping),
                                 port);
}

RC_GTEST_PROP(DampingProperty, DeliveredIsNeverMoreThanBurnedInFloat, ()) {
  const int which = random_law();
  const Port port = random_port();
  const Script script = *scripts({.reduces = true});
  never_more_than_burned<float>(script, law_of(which, port.damping, port.rotational_damping), port);
}

RC_GTEST_PROP(DampingProperty, AlongTheAxesToo, ()) {
  const auto axis = [] { return std::pow(10.0, -0.1 * *rc::gen::inRange(0, 40)); };
  const Port port{Damping(Vec3(axis(), axis(), axis())),
                  Damping(Vec3(1e-3 * axis(), 1e-3 * axis(), 1e-3 * axis()))};
  const Script script = *scripts({.reduces = true});
  never_more_than_burned<double>(script,
                                 law_of(random_law(), port.damping, port.rotational_damping), port);
}

// For a matrix that couples the axes, each axis uses its least damping.
RC_GTEST_PROP(DampingProperty, PerAxisIsPassiveUnderAMatrix, ()) {
  const Port port = random_port();
  BoundingConfig c = law_of(0, port.damping, port.rotational_damping);
  c.mode = "per_axis";
  never_more_than_burned<double>(*scripts({.reduces = true}), c, port);
}

// Mutant: the method assumes five percent too much damping in all directions.
TEST(DampingMutant, FivePercentTooMuchOfAMatrixLoses) {
  for (int which = 0; which < kLaws; ++which) {
    bool won = false;
    for (std::uint64_t seed = 0; seed < 50 && !won; ++seed) {
      const rc::Random random(seed);
      const Port port{Damping(random_damping(0.5, 100.0)(random, 0).value()),
                      Damping(random_damping(1e-3, 100.0)(random, 0).value())};
      const Mat3 force = 1.05 * port.damping.matrix(),
                 torque = 1.05 * port.rotational_damping.matrix();
      Margin margin{port};
      play(scripts({})(random, 0).value(), {law_of(which, Damping(force), Damping(torque))}, port,
           [&](const Played<double>& p, const auto&) {
             margin.account(p);
             won = won || !margin.kept<double>(condition(port));
           });
    }
    EXPECT_TRUE(won) << which;
  }
}

/// Plays a script to two bounds and compares their forces. After each sample both bounds hold the
/// force of the first. Rounding errors therefore do not add up.
template <class Same>
void same_forces(const Script& script, const BoundingConfig& a, const BoundingConfig& b,
                 const Mat3& turned, Same same) {
  Bounding other(b);
  play(script, {a}, {a.damping, a.rotational_damping}, [&](const Played<double>& p, const auto&) {
    BoundingStep s = p.told;
    for (Vec3* v : {&s.displacement, &s.rotation, &s.command.elastic, &s.command.frictional,
                    &s.command.torque})
      *v = turned * *v;
    const Command got = other.step(s).rendered;
    const Command expected{turned * p.out.rendered.elastic, turned * p.out.rendered.frictional,
                           turned * p.out.rendered.torque};
    same(got, expected, p);
    other.set_held({turned * p.held.elastic, turned * p.held.frictional, turned * p.held.torque});
  });
}

/// A force is the square root of an energy. For a nearly empty store, the root of the rounding
/// error remains: 1e-8 of the largest force so far.
struct Close {
  double condition, force = 0.0, torque = 0.0;
  void operator()(const Command& got, const Command& expected, const Played<double>& p) {
    force = std::max(
        {force, expected.elastic.norm() + expected.frictional.norm(), 2e3 * p.displacement.norm()});
    torque = std::max({torque, expected.torque.norm(), 2.0 * p.rotation.norm()});
    const double root = 1e-6 * std::sqrt(condition);
    RC_ASSERT((got.elastic - expected.elastic).norm() <= root * force);
    RC_ASSERT((got.frictional - expected.frictional).norm() <= root * force);
    RC_ASSERT((got.torque - expected.torque).norm() <= root * torque);
  }
};

RC_GTEST_PROP(DampingProperty, AMatrixThatIsANumberGivesTheNumbersForces, ()) {
  const int which = random_law();
  const Script script = *scripts({.reduces = true});
  same_forces(script, law_of(which, 0.5, 1e-3),
              law_of(which, Mat3(0.5 * Mat3::Identity()), Mat3(1e-3 * Mat3::Identity())),
              Mat3::Identity(), Close{1.0});
}

RC_GTEST_PROP(DampingProperty, AxesThatAreOneNumberGiveTheNumbersForces, ()) {
  const int which = random_law();
  const Script script = *scripts({.reduces = true});
  same_forces(script, law_of(which, 0.5, 1e-3),
              law_of(which, Vec3(0.5, 0.5, 0.5), Vec3(1e-3, 1e-3, 1e-3)), Mat3::Identity(),
              Close{1.0});
}

RC_GTEST_PROP(DampingProperty, TurningTheWorldTurnsTheResult, ()) {
  const int which = random_law();
  const Mat3 r = *random_orientation();
  const Port port{Damping(*random_damping(0.5, 100.0)), Damping(*random_damping(1e-3, 100.0))};
  const auto turned = [&](const Damping& d) {
    const Mat3 m = r * d.matrix() * r.transpose();
    return Damping(Mat3(0.5 * (m + m.transpose())));
  };
  const Script script = *scripts({.reduces = true});
  same_forces(script, law_of(which, port.damping, port.rotational_damping),
              law_of(which, turned(port.damping), turned(port.rotational_damping)), r,
              Close{condition(port)});
}

// For any damping, `joint` must give a share of the command: elastic force (never a pull) and
// friction.
RC_GTEST_PROP(DampingProperty, JointKeepsTheDirection, ()) {
  const int which = 2 * *rc::gen::inRange(0, 2);  // both storages
  const Port port = random_port();
  const Script script = *scripts({.reduces = true});
  const double ulp = 64.0 * std::numeric_limits<double>::epsilon() * condition(port);
  play(script, {law_of(which, port.damping, port.rotational_damping)}, port,
       [&](const Played<double>& p, const auto&) {
         const ChannelCommand<double> c = in_channels(p.told.command);
         const Vec3 wanted = std::max(0.0, c.elastic) * c.normal + c.frictional;
         const Vec3 got = p.out.rendered.force();
         RC_ASSERT(got.cross(wanted).norm() <= ulp * got.norm() * (wanted.norm() + c.spring));
         RC_ASSERT(got.norm() <= (1.0 + ulp) * wanted.norm() + ulp * c.spring);
         RC_ASSERT(p.out.rendered.torque.cross(p.told.command.torque).norm() <=
                   ulp * got.norm() + ulp * p.told.command.torque.norm());
       });
}

// The result of greediest() must equal the worst movement in the metric. No movement may extract
// more energy.
RC_GTEST_PROP(DampingProperty, TheWorstMovementIsB_1FOverTwo, ()) {
  const Damping damping(*random_damping(0.5, kWorstCondition));
  const Metric<double> metric(damping);
  const std::uint64_t seed = *rc::gen::arbitrary<std::uint64_t>();
  Random random(seed);
  const Vec3 f = random.vector(-3.0, 3.0), dx = random.vector(-6.0, -1.0);
  const double h = kModePeriod * random.uniform(1.0, 5.0);
  const double cond = damping.matrix().trace() / damping.least(), eps = 1e-13 * cond;
  const auto margin = [&](const Vec3& moved) {
    return damping.quadratic(moved) / h - f.dot(moved);
  };

  const Vec3 worst = metric.worst_movement(f, h);
  const Vec3 expected = greediest(f, h, damping);
  RC_ASSERT((worst - expected).norm() <= eps * expected.norm());
  RC_ASSERT(std::abs(margin(worst) + 0.5 * f.dot(expected)) <= eps * std::abs(f.dot(expected)));
  const auto magnitude = [&](const Vec3& moved) {
    return damping.quadratic(moved) / h + f.norm() * moved.norm();
  };
  RC_ASSERT(margin(worst + dx) >= margin(worst) - eps * (magnitude(worst) + magnitude(dx)));
  // The metric keeps the work, and turns the damping into the number b.
  const Vec3 y = metric.movement(dx), g = metric.force(f);
  RC_ASSERT(std::abs(g.dot(y) - f.dot(dx)) <= eps * f.norm() * dx.norm());
  RC_ASSERT(std::abs(metric.damping() * y.squaredNorm() - damping.quadratic(dx)) <=
            eps * damping.quadratic(dx));
  RC_ASSERT((metric.force_back(g) - f).norm() <= eps * f.norm());
}

}  // namespace
}  // namespace feltwire::damping_properties_test
