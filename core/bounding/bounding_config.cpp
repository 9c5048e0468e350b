#include "core/bounding/bounding_config.hpp"

#include "core/base/enum_names.hpp"

namespace feltwire {

std::string_view name(Projection p) { return enum_name(kProjectionNames, p); }
std::string_view name(Storage s) { return enum_name(kStorageNames, s); }
std::string_view name(PassivityReference r) { return enum_name(kPassivityReferenceNames, r); }

Projection projection(std::string_view given) {
  return enum_from_name<Projection>("projection", given, kProjectionNames);
}
Storage storage(std::string_view given) {
  return enum_from_name<Storage>("storage", given, kStorageNames);
}
PassivityReference passivity_reference(std::string_view given) {
  return enum_from_name<PassivityReference>("passivity reference", given, kPassivityReferenceNames);
}

}  // namespace feltwire
