#include "sim/studies/extremes/extreme_parts.hpp"

#include "sim/studies/extremes/contact_extremes.hpp"
#include "sim/studies/extremes/dynamics_extremes.hpp"
#include "sim/studies/extremes/local_model_extremes.hpp"
#include "sim/studies/extremes/teleoperation_extremes.hpp"
#include "sim/studies/extremes/wire_extremes.hpp"

namespace feltwire {

const std::array<ExtremePart, 5> kExtremeParts = {{{"contact", run_contact_extremes},
                                                   {"dynamics", run_dynamics_extremes},
                                                   {"wire", run_wire_extremes},
                                                   {"local", run_local_model_extremes},
                                                   {"teleoperation", run_teleoperation_extremes}}};

}  // namespace feltwire
