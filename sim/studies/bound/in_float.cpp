#include "sim/studies/bound/in_float.hpp"

#include <stdexcept>
#include <string>

#include "core/bounding/bounding_template.hpp"
#include "core/bounding/built_in_methods.hpp"
#include "core/bounding/contact_frame_template.hpp"

namespace feltwire {

template class ContactFrameBound<float>;
template class BasicBounding<float>;

const BasicBoundingMethod<float>* method_in_float(std::string_view name) {
  static const auto methods = built_in_methods<float>();
  return find_named(methods, name, &BasicBoundingMethod<float>::name);
}

template <>
BasicBounding<double> bounding_in<double>(const BoundingConfig& config) {
  return Bounding(config);
}
template <>
BasicBounding<float> bounding_in<float>(const BoundingConfig& config) {
  if (const auto* method = method_in_float(config.mode)) return {*method, config};
  throw std::invalid_argument("the bounding method '" + std::string(config.mode) +
                              "' has no law in single precision");
}

}  // namespace feltwire
