#include "core/bounding/config.hpp"

#include "core/base/choice.hpp"

namespace feltwire {

std::string_view name(Projection p) { return name_among(kProjectionNames, p); }
std::string_view name(Storage s) { return name_among(kStorageNames, s); }
std::string_view name(PassivityReference r) { return name_among(kPassivityReferenceNames, r); }

Projection projection(std::string_view given) {
  return chosen_value<Projection>("projection", given, kProjectionNames);
}
Storage storage(std::string_view given) {
  return chosen_value<Storage>("storage", given, kStorageNames);
}
PassivityReference passivity_reference(std::string_view given) {
  return chosen_value<PassivityReference>("passivity reference", given, kPassivityReferenceNames);
}

}  // namespace feltwire
