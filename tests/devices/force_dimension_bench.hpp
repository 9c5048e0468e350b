#pragma once
// A bench for Force Dimension's driver, with a new stand-in of the maker's library for each test.

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "client/drivers/force_dimension/force_dimension.hpp"
#include "client/servo/servo.hpp"
#include "tests/devices/drd_stand_in.hpp"
#include "tests/devices/stand_in_session.hpp"

namespace feltwire::force_dimension_test {

inline Command pull(double x, double y, double z) { return {.elastic = Vec3(x, y, z)}; }

struct ForceDimension : ::testing::Test {
  ForceDimension() : library(::dlopen(FELTWIRE_DRD_STAND_IN, RTLD_NOW | RTLD_LOCAL)) {
    ::setenv("FDSDK", FELTWIRE_FDSDK, 1);
    using New = stand_in::Drd*();
    stand_in = reinterpret_cast<New*>(::dlsym(library, "stand_in_new"))();
  }
  ~ForceDimension() override {
    ::unsetenv("FDSDK");
    ::dlclose(library);
  }
  static OpenedDevice open(const std::string& name = "") {
    DeviceRequest request;
    request.name = name;
    return open_force_dimension(request);
  }
  /// A device whose physical numbers are known: the stand-in's.
  OpenedDevice known() const {
    DeviceRequest request;
    request.spec.damping = stand_in->mass.damping;
    request.spec.mass = stand_in->mass.mass;
    OpenedDevice opened = open_force_dimension(request);
    return opened;
  }
  static std::string refusal(const std::string& name = "") {
    try {
      open(name);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "none";
  }
  /// [J] that the true motion made beyond the burned energy, in a minute at a late wall.
  double made(std::string_view mode = kSessionMethod, double twist = 0.0) {
    const OpenedDevice opened = known();
    SessionParameters parameters = testing::session_of(*opened.device);
    parameters.mode = mode;
    DeviceSpec spec = opened.device->spec();
    spec.position_resolution = stand_in->mass.quantum;
    spec.least_friction = stand_in->mass.friction;
    Servo servo(spec, parameters, {});
    testing::WallSession session{.twist = twist, .period = stand_in->period};
    session.run(*opened.device, servo, 60.0);
    statistics = servo.statistics();
    return twist > 0.0 ? stand_in->most_made : stand_in->mass.most_made;
  }

  void* library;
  stand_in::Drd* stand_in;
  ServoStatistics statistics;
};

}  // namespace feltwire::force_dimension_test
