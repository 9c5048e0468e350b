#include "core/guidance/load_guides.hpp"

#include <cmath>
#include <limits>

#include "core/scene/rules.hpp"
#include "core/scene/scene_generated.h"

namespace feltwire {
namespace {

Vec3 vector(const scene_file::Vector& v) { return {v.x(), v.y(), v.z()}; }

/// What was not given has no end.
double endless(double value) {
  return std::isnan(value) ? std::numeric_limits<double>::infinity() : value;
}

/// Keeps the one that is given, and says so where there is another.
template <class Value>
class OneOf {
 public:
  OneOf(const JsonDocument& document, std::string path, const char* choices)
      : document_(document), path_(std::move(path)), choices_(choices) {}
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
  std::string path_, name_;
  const char* choices_;
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
  OneOf<GuidePlace> place(document, path,
                          "point, line, curve, plane, sphere, box, capsule, cylinder");
  if (guide.point()) place.take("point", GuidePoint{});
  if (const auto* l = guide.line()) place.take("line", GuideLine{0.5 * endless(l->length())});
  if (const auto* c = guide.curve()) place.take("curve", read_curve(*c));
  if (guide.plane()) place.take("plane", GuidePlane{});
  if (const auto* s = guide.sphere()) place.take("sphere", Sphere{s->radius()});
  if (const auto* b = guide.box()) {
    if (!b->size()) document.fail(path + ".box.size", "is missing; give [x, y, z] in metres");
    place.take("box", Box{0.5 * vector(*b->size())});
  }
  if (const auto* c = guide.capsule())
    place.take("capsule", Capsule{c->radius(), 0.5 * c->length()});
  if (const auto* c = guide.cylinder())
    place.take("cylinder", Cylinder{c->radius(), 0.5 * c->length()});
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
  for (const scene_file::Guide* g : *scene.guides()) {
    const std::string path = "guides[" + std::to_string(guides.size()) + "]";
    const auto require = [&](const Found& broken) {
      if (broken) document.fail(path + "." + broken->field, broken->message);
    };
    Guide guide;
    guide.name = g->name()->str();
    require(broken_name(guide.name));
    for (std::size_t i = 0; i < guides.size(); ++i)
      if (guides[i].name == guide.name)
        document.fail(path + ".name", "'" + guide.name + "' is the name of guides[" +
                                          std::to_string(i) + "] too; rename one");
    guide.place = read_place(document, path, *g);
    guide.action = read_action(document, path, *g);
    if (const auto* p = g->position()) guide.pose.position = vector(*p);
    if (const auto* q = g->orientation())
      guide.pose.orientation = Quaternion(q->w(), q->x(), q->y(), q->z());
    guide.max_force = g->max_force();
    require(broken_rule(guide));
    guides.push_back(std::move(guide));
  }
  return guides;
}

}  // namespace feltwire
