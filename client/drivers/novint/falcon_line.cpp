#include "client/drivers/novint/falcon_line.hpp"

#include <array>
#include <chrono>
#include <span>
#include <utility>

#include "protocol/net/clock.hpp"
#include "protocol/net/real_time.hpp"

namespace feltwire::falcon {
namespace {

// Longest time of a USB transfer. A later answer counts as missing, and LockStepDevice restarts the
// exchange.
constexpr Nanoseconds kTransfer = std::chrono::milliseconds(20);

const Packet& no_force() noexcept {
  static const Packet packet = request({}, Light::red, false);
  return packet;
}

}  // namespace

AnswerStatus ask(UsbLine& line, const Packet& request, Answer& answer, const Patience& patience) {
  answer.clear();
  const auto sent = line.write(request, patience.send);
  if (!sent) return AnswerStatus::gone;
  if (*sent != request.size()) return AnswerStatus::unsent;
  const Nanoseconds latest = monotonic_now() + patience.answer;
  std::array<std::uint8_t, 62> room{};
  while (!answer.whole() && !answer.garbled()) {
    const Nanoseconds left = latest - monotonic_now();
    if (left.count() <= 0) return AnswerStatus::none;
    const auto came = line.read(room, left);
    if (!came) return AnswerStatus::gone;
    answer.add(std::span(room).first(*came));
  }
  return answer.garbled() ? AnswerStatus::garbled : AnswerStatus::whole;
}

FalconLine::FalconLine(std::unique_ptr<UsbLine> line)
    : line_(std::move(line)), thread_([this] { run(); }) {}

FalconLine::~FalconLine() {
  let_go();
  over_.store(true);
  line_wake_.set();
  thread_.join();
}

bool FalconLine::post(const Packet& request) noexcept {
  const bool taken = requests_.push(request);
  line_wake_.set();
  return taken;
}

FalconLine::LineAnswer FalconLine::receive(Nanoseconds latest) noexcept {
  LineAnswer news;
  while (!answers_.pop(news)) {
    if (gone_.load()) return {.kind = AnswerStatus::gone};
    if (monotonic_now() >= latest) return {};
    servo_wake_.wait_until(latest);
  }
  return news;
}

void FalconLine::forget() noexcept {
  LineAnswer news;
  while (answers_.pop(news)) continue;
}

void FalconLine::let_go() noexcept {
  let_go_.store(true);
  line_wake_.set();
}

void FalconLine::run() noexcept {
  request_real_time(kServoPriority);
  while (!over_.load()) {
    line_wake_.wait();
    Packet newest;
    bool asked = let_go_.load();
    while (requests_.pop(newest)) asked = true;
    if (asked && !gone_.load()) exchange(newest);
  }
  if (!gone_.load()) ask(*line_, no_force(), answer_, {kTransfer, kTransfer});
}

void FalconLine::exchange(const Packet& request) noexcept {
  LineAnswer news;
  const Packet& sent = let_go_.load() ? no_force() : request;
  news.kind = ask(*line_, sent, answer_, {kTransfer, kTransfer});
  news.packet = answer_.packet();
  gone_.store(news.kind == AnswerStatus::gone);
  if (news.kind != AnswerStatus::none) answers_.push(news);
  servo_wake_.set();
}

}  // namespace feltwire::falcon
