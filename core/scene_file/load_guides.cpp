#include "core/scene_file/load_guides.hpp"

#include <cmath>
#include <limits>

#include "core/scene_file/read_values.hpp"

namespace feltwire {
namespace {

/// Replaces a missing number (NaN) by infinity.
double endless(double value) {
  return std::isnan(value) ? std::numeric_limits<double>::infinity() : value;
}

/// Stores one of several alternatives. Reports an error if a second alternative is given too.
template <class Value>
class OneOf {
 public:
  OneOf(const JsonDocument& document, std::string path, std::string choices)
      : document_(document), path_(std::move(path)), choices_(std::move(choices)) {}
  void take(const char* name, Value value) {
    if (!name_.empty())
      document_.fail(path_ + "." + name, "stands beside " + name_ + "; keep one of " + choices_);
    name_ = name;
    value_ = std::move(value);
  }
  bool given() const { return !name_.empty(); }
  const Value& value() const { return value_; }

 private:
  const JsonDocument& document_;
  std::string path_, choices_, name_;
  Value value_;
};

GuideCurve read_curve(const scene_file::Curve& given) {
  GuideCurve curve;
  curve.closed = given.closed();
  if (given.points() != nullptr)
    for (const scene_file::Vector* point : *given.points()) curve.points.push_back(vector(*point));
  return curve;
}

GuidePlace read_place(const JsonDocument& document, const std::string& path,
                      const scene_file::Guide& guide) {
  OneOf<GuidePlace> place(document, path, "point, line, curve, " + names_of_primitives(false));
  if (guide.point()) place.take("point", GuidePoint{});
  if (const auto* l = guide.line()) place.take("line", GuideLine{0.5 * endless(l->length())});
  if (const auto* c = guide.curve()) place.take("curve", read_curve(*c));
  take_primitives(document, path,
                  [&](const char* name, const auto& solid) { place.take(name, solid); });
  return place.given() ? place.value() : GuidePlace(Everywhere{});
}

GuideAction read_action(const JsonDocument& document, const std::string& path,
                        const scene_file::Guide& guide) {
  constexpr const char* kChoices = "attract, keep_out, magnet, viscosity, constant";
  OneOf<GuideAction> action(document, path, kChoices);
  if (const auto* a = guide.attract())
    action.take("attract", Attract{a->stiffness(), a->damping(), endless(a->range())});
  if (const auto* k = guide.keep_out())
    action.take("keep_out", KeepOut{k->stiffness(), k->damping(), k->margin()});
  if (const auto* m = guide.magnet()) action.take("magnet", Magnet{m->reach()});
  if (const auto* v = guide.viscosity()) action.take("viscosity", Viscosity{v->damping()});
  if (const auto* c = guide.constant()) {
    if (!c->force())
      document.fail(path + ".constant.force", "is missing; give [x, y, z] in newtons");
    action.take("constant", ConstantForce{vector(*c->force())});
  }
  if (!action.given())
    document.fail(path, std::string("does nothing; give exactly one of ") + kChoices);
  return action.value();
}

}  // namespace

std::vector<Guide> read_guides(const JsonDocument& document, const scene_file::Scene& scene) {
  std::vector<Guide> guides;
  if (scene.guides() == nullptr) return guides;
  Names names(document, "guides");
  for (const scene_file::Guide* g : *scene.guides()) {
    const std::string path = element("guides", guides.size());
    Guide guide;
    guide.name = g->name()->str();
    names.add(guide.name);
    guide.place = read_place(document, path, *g);
    guide.action = read_action(document, path, *g);
    guide.pose = pose_of(*g);
    guide.max_force = g->max_force();
    require(document, path, check(guide));
    guides.push_back(std::move(guide));
  }
  return guides;
}

}  // namespace feltwire
