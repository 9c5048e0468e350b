#include "core/tool/shell_contact.hpp"

#include "core/coupled_tool/shell_query.hpp"
#include "core/grid/signed_distance.hpp"

namespace feltwire {
namespace {

struct ShapeField {
  const Shape& shape;
  Side side;

  double at_least(const Vec3& place, double wanted) const noexcept {
    return distance_at_least(shape, side, place, wanted);
  }
  void at_least(FieldGroup& group, const FieldGroup::Lanes& wanted) const noexcept {
    distance_at_least(shape, side, group, wanted);
  }
  void at(FieldGroup& group) const noexcept { signed_distance(shape, side, group); }
};

}  // namespace

void add_contact(const PointShell& shell, const Pose& tool, const Object& object,
                 double contact_area, ShellContact& sum, const ObjectInStep& in) noexcept {
  add_shell_contact(
      shell, tool, ShapeField{object.shape, object.felt_from}, object.material, contact_area, sum,
      {.index = in.index, .pose = object.pose, .share = in.share, .carried = in.carried});
}

}  // namespace feltwire
