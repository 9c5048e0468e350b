#pragma once
// A hand that gets the answers of a scene and of a local model side by side.

#include "core/local_model/local_contact.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "tests/core/support.hpp"

namespace feltwire::test {

/// A hand that wanders about a place, some hundredths of a millimetre per sample of 1 ms.
class WanderingHand {
 public:
  /// kick [m]: the most per sample; `pull`: the share of the way back that each sample takes.
  WanderingHand(Random& random, const Vec3& place, double kick = 3e-5, double pull = 1e-3)
      : random_(random), place_(place), position_(place), kick_(kick), pull_(pull) {}
  Tool step() {
    velocity_ = 0.97 * velocity_ + random_.uniform(0.0, kick_) * random_.direction();
    position_ += velocity_ + pull_ * (place_ - position_);
    return {position_, velocity_ / 1e-3};
  }

 private:
  Random& random_;
  Vec3 place_, position_, velocity_ = Vec3::Zero();
  double kick_, pull_;
};

/// Gives a tool the answers of the scene and of a client that gets a model every `every` ticks of
/// 1 ms. After it left its model's reach, the client begins anew with the next model.
class FollowedHand {
 public:
  FollowedHand(const Scene& scene, int every)
      : scene_(scene), every_(every), memory_(scene.memory()) {}

  /// Touches the scene only, without models.
  Command approach(const Tool& tool) { return scene_.touch(tool, memory_); }

  /// A tick. True if the model alone has answered since the last model arrived.
  bool step(const Tool& tool) {
    return step(tool, [&](const Vec3& asked) { return local_model(scene_, asked, memory_); });
  }
  /// A tick with models from elsewhere: model_at(position of the last tick).
  template <class ModelAt>
  bool step(const Tool& tool, ModelAt model_at) {
    if (ticks_ > 0 && (ticks_ - 1) % every_ == 0) {
      if (!alone_) local_.clear();
      asked_ = last_.position;
      local_.take(model_at(asked_), &truth_);
      reach_ += local_.model().reach;
      ++models_;
      alone_ = true;
    }
    truth_ = scene_.touch(tool, memory_);
    const LocalForce force = local_.touch(tool, 0.0, 1e-3);
    said_ = force.command;
    alone_ = alone_ && force.weight == 1.0;
    last_ = tool;
    ++ticks_;
    return alone_;
  }

  const Command& truth() const { return truth_; }
  const Command& said() const { return said_; }
  double error() const { return (said_.force() - truth_.force()).norm(); }  // [N]
  const Tool& tool() const { return last_; }
  const TouchMemory& memory() const { return memory_; }
  const LocalModel& model() const { return local_.model(); }
  const Vec3& asked() const { return asked_; }  // [m] the place for which the model was made
  double reach() const { return models_ > 0 ? reach_ / models_ : 0.0; }  // [m] mean

 private:
  const Scene& scene_;
  int every_;
  TouchMemory memory_;
  LocalContact local_;
  Command truth_, said_;
  Tool last_;
  Vec3 asked_ = Vec3::Zero();
  bool alone_ = false;
  int ticks_ = 0, models_ = 0;
  double reach_ = 0.0;
};

/// Leads a hand from free space to an object until it feels it; returns that place [m, world].
/// `core` [m, object's frame] is in the solid, or in the hollow of an object felt from inside.
inline Vec3 led_to(FollowedHand& hand, const Object& object, const Vec3& core, Random& random) {
  const bool outside = object.felt_from == Side::outside;
  const Vec3 middle = object.pose.position + object.pose.orientation * core;
  Vec3 place = middle + (outside ? 0.15 : 0.01) * random.direction();
  const Vec3 towards = outside ? Vec3((middle - place).normalized()) : random.direction();
  for (int n = 0; n < 200 && hand.approach({place, Vec3::Zero()}).elastic.isZero(0.0); ++n)
    place += 1e-3 * towards;
  return place;
}

}  // namespace feltwire::test
