#pragma once
// Makes a local model shorter on the wire, for a path that takes no long replies.

#include <cstddef>

#include "core/local_model/body_model.hpp"
#include "core/local_model/local_model.hpp"

namespace feltwire {

/// Drops the farthest patches, so that the model is about `excess` [bytes] shorter, and reduces its
/// reach so that it does not cover them. In the end the model is empty.
void shorten(LocalModel& model, std::size_t excess) noexcept;

/// The number of points with which the model of a body is about `excess` [bytes] shorter; below 0:
/// even without points it is not.
int shortened_points(const BodyModel& model, std::size_t excess) noexcept;

}  // namespace feltwire
