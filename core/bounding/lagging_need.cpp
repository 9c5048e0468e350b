#include "core/bounding/lagging_need.hpp"

#include <cmath>

#include "core/base/numeric.hpp"

namespace feltwire {

LaggingNeed::LaggingNeed(const PortBalance& port, const LaggingForces& older, const Vec3& wanted,
                         double hold, int late, double driving) noexcept
    : squared_(wanted.squaredNorm()) {
  length_ = std::sqrt(squared_);
  const double strongest = std::max(length_, driving);
  if (strongest == 0.0) return;
  along_ = wanted.dot(older[0].force);
  newest_squared_ = older[0].force.squaredNorm();
  turns_ = port.turn_limit(strongest, hold);
  double weight = 1.0;
  while (weight > 0.0 && count_ < samples_.size()) {
    const int i = static_cast<int>(count_);
    const double ahead = hold * static_cast<double>(i);
    OfSample& sample = samples_[count_++];
    sample.weight = weight;
    // In the next sample, the wanted force f and the rest of the older forces drive the handle.
    sample.wanted = port.need_after(wanted, hold, late + i, i == 0 ? driving : strongest);
    limited_ = limited_ && (squared_ == 0.0 || sample.wanted.limited());
    if (late + i > 0) sample.rounded = port.quantum() * wanted.lpNorm<1>();
    const Vec3* newer = nullptr;
    double worst = 0.0;  // [J] largest need of the older forces so far
    for (std::size_t j = 0; j < older.count(); ++j) {
      const auto& [force, age] = older[j];
      const double share = older.share(age, ahead, hold);
      if (!(share > 0.0)) break;
      worst = std::max(worst, port.need_after(force, hold, late + i, strongest).at(1.0) +
                                  port.quantum() * force.lpNorm<1>());
      sample.older[sample.count] = share;
      sample.worst[sample.count++] = worst;
      if (newer != nullptr)
        sample.changes += turns_.energy(length(force - *newer), TurnLimit::spread(share));
      newer = &force;
    }
    weight = older.share(0.0, ahead, hold);
    if (i > 0) sample.ends = TurnLimit::spread(sample.weight);
    sample.begins = TurnLimit::spread(weight);
  }
}

double LaggingNeed::of_sample(std::size_t i, double s) const noexcept {
  const OfSample& sample = samples_[i];
  const double own = sample.wanted.at(s) + s * sample.rounded;
  // Share of the sample's mean force that comes from all older forces.
  const double most = sample.older[0];
  double sum = (sample.weight - most) * own + sample.changes;
  for (std::size_t j = 0; j < sample.count; ++j)
    sum += (sample.older[j] - sample.older[j + 1]) * std::max(own, sample.worst[j]);
  // The force changes from the newest older force to s f, where f is the wanted force. In later
  // samples, it changes from s f to zero.
  const double change =
      std::sqrt(std::max(0.0, newest_squared_ + s * (s * squared_ - 2.0 * along_)));
  sum += turns_.energy(change, sample.begins) + turns_.energy(s * length_, sample.ends);
  return sum;
}

}  // namespace feltwire
