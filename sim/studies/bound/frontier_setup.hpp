#pragma once
// The tasks and the setup of a case of the frontier.

#include <string>
#include <vector>

#include "core/contact/contact.hpp"
#include "sim/measure/experiment.hpp"
#include "sim/studies/bound/compare_tasks.hpp"
#include "sim/studies/bound/frontier.hpp"

namespace feltwire {

inline constexpr double kFrontierPeriod = 1e-3;  // [s] servo period
inline constexpr double kFrontierPress = 3.0;    // [N] force with which the hand presses
inline constexpr double kFrontierAir = 2.0;      // [s] free motion before contact, if not cold

/// The objects and tasks of all cases. They are made only once, because it is slow to parse a
/// scene. Environments refer to them.
struct TaskSource {
  TaskSource();
  Object paper_wall, paper_sphere, mesh;
  std::vector<CompareTask> compared;
};

/// Throws std::invalid_argument if there is no such task.
CompareTask task_of(const FrontierCase& c, const TaskSource& source);
/// Hand, device, law and account of a case.
ExperimentSetup setup_of(const FrontierCase& c, const CompareTask& task);

}  // namespace feltwire
