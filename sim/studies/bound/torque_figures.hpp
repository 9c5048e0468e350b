#pragma once
// Eq. (3) for torque: Figures 5 and 6 of the paper, turned. The hand leans a joint against the stop
// of its cone and goes round it; the arrows are torques on the hand.

#include <filesystem>
#include <string>
#include <vector>

#include "sim/studies/bound/figures.hpp"
#include "sim/studies/bound/torque.hpp"

namespace feltwire {

struct TorqueFigure {
  std::string_view mode = kUnbounded;  // of kFigureModes
  std::vector<SixDofSample> samples{};
  double torque_share = 0.0;  // rendered along commanded, of the commanded, second half
  Spread direction_error{};   // [rad] rendered against commanded torque, where there are both
  double energy_made =
      0.0;  // [J] by the torque, beyond the energy that the device burned in rotation
};

/// 8 N m/rad beyond a lean of 0.2 rad, b_r = 8e-4 N m s/rad, the usual hand, one turn in 4 s.
TorqueFigure run_torque_figure(std::string_view mode);

/// Runs every mode and writes torque_figures.json, a CSV a run (torque_cone_MODE.csv: t [s],
/// ax,ay,az turn [rad], ex,ey,ez commanded and rx,ry,rz rendered torque [N m]) and
/// torque_figure5.png, torque_figure6.png and torque_modes.png to `directory` (created). Throws
/// std::runtime_error when something cannot be written or drawn. Returns the runs without samples.
std::vector<TorqueFigure> write_torque_figures(const std::filesystem::path& directory);

std::string torque_figures_table(const std::vector<TorqueFigure>& figures);

}  // namespace feltwire
