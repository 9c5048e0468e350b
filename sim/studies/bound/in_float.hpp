#pragma once
// The bounding methods in single precision, for the studies that compare arithmetics.

#include <string_view>

#include "core/bounding/bounding.hpp"
#include "core/bounding/contact_frame.hpp"

namespace feltwire {

extern template class ContactFrameBound<float>;
extern template class BasicBounding<float>;

/// The method with that name; null if it has no law in single precision: feltwire's own have.
const BasicBoundingMethod<float>* method_in_float(std::string_view name);

/// The bound of the method that config.mode names, in either arithmetic. Throws
/// std::invalid_argument as Bounding does, and where method_in_float() finds none.
template <class Real>
BasicBounding<Real> bounding_in(const BoundingConfig& config) = delete;
template <>
BasicBounding<double> bounding_in<double>(const BoundingConfig& config);
template <>
BasicBounding<float> bounding_in<float>(const BoundingConfig& config);

}  // namespace feltwire
