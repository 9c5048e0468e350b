#include "protocol/session/bound_words.hpp"

namespace feltwire {

SessionParameters with_words(SessionParameters parameters, const BoundWords& words) {
  if (words.mode) parameters.mode = bounding_method(*words.mode).name;
  if (words.projection) parameters.projection = projection(*words.projection);
  if (words.storage) parameters.storage = storage(*words.storage);
  if (words.reference) parameters.reference = passivity_reference(*words.reference);
  for (const BoundNumber& number : kBoundNumbers)
    if (const std::optional<double>& wanted = words.*number.wanted)
      std::visit([&](auto field) { parameters.*field = *wanted; }, number.value);
  return parameters;
}

}  // namespace feltwire
