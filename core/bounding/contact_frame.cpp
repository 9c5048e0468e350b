#include "core/bounding/contact_frame_template.hpp"

namespace feltwire {

template class ContactFrameBound<double>;

}  // namespace feltwire
