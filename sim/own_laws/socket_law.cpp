#include "sim/own_laws/socket_law.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <stdexcept>
#include <string>
#include <system_error>

#include "sim/own_laws/feltwire_law_v1.h"
#include "sim/own_laws/own_law.hpp"

namespace feltwire {
namespace {

static_assert(std::endian::native == std::endian::little, "frames are sent as they are in memory");

constexpr std::uint32_t kReset = 1, kStep = 2, kHeld = 3;
constexpr std::size_t kNumbers = 25;
constexpr std::uint32_t kLongestText = 1 << 16;  // [bytes] of a name or an error

struct Request {
  std::uint32_t kind = 0, law = 0;
  std::uint64_t run = 0;
  std::array<double, kNumbers> numbers{};
};
static_assert(sizeof(Request) == 216);

struct Answer {
  std::uint32_t failed = 0, text_size = 0;
  std::array<double, 9> numbers{};
};
static_assert(sizeof(Answer) == 80);

struct Description {
  std::uint32_t promise = 0, kept_despite = 0, admits_reduction = 0, name_size = 0;
};

/// The socket to the process that has the laws. One request at a time is under way.
class LawSocket {
 public:
  explicit LawSocket(int socket) : socket_(socket) {}

  void receive(void* to, std::size_t size) {
    for (auto* at = static_cast<char*>(to); size > 0;) {
      const ssize_t got = ::recv(socket_, at, size, MSG_WAITALL);
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) throw std::runtime_error("the process that has the law has ended");
      at += got;
      size -= static_cast<std::size_t>(got);
    }
  }
  std::string receive_text(std::uint32_t size) {
    if (size > kLongestText) throw std::runtime_error("a text of the law is too long");
    std::string text(size, '\0');
    receive(text.data(), size);
    return text;
  }
  void tell(const Request& request) {
    const std::scoped_lock lock(mutex_);
    send(request);
  }
  std::array<double, 9> ask(const Request& request) {
    const std::scoped_lock lock(mutex_);
    send(request);
    Answer answer;
    receive(&answer, sizeof answer);
    if (answer.failed != 0) throw std::runtime_error(receive_text(answer.text_size));
    return answer.numbers;
  }
  std::uint64_t new_run() {
    const std::scoped_lock lock(mutex_);
    return ++runs_;
  }

 private:
  void send(const Request& request) {
    const auto* at = reinterpret_cast<const char*>(&request);
    for (std::size_t left = sizeof request; left > 0;) {
      const ssize_t sent = ::send(socket_, at, left, MSG_NOSIGNAL);
      if (sent < 0 && errno == EINTR) continue;
      if (sent < 0) throw std::runtime_error("the process that has the law has ended");
      at += sent;
      left -= static_cast<std::size_t>(sent);
    }
  }

  int socket_;
  std::mutex mutex_;
  std::uint64_t runs_ = 0;
};

/// Writes numbers one after the other into a request.
struct Numbers {
  Request& request;
  std::size_t at = 0;

  void add(double number) { request.numbers[at++] = number; }
  void add(const double* numbers, std::size_t count) {
    std::copy_n(numbers, count, request.numbers.begin() + static_cast<std::ptrdiff_t>(at));
    at += count;
  }
  void add(const Command& c) {
    for (const Vec3* v : {&c.elastic, &c.frictional, &c.torque}) add(v->data(), 3);
  }
};

class SocketLaw final : public OwnLaw {
 public:
  SocketLaw(std::shared_ptr<LawSocket> socket, std::uint32_t index)
      : socket_(std::move(socket)), index_(index) {}

  void reset(const BoundingConfig& config, std::byte* memory) override {
    const std::uint64_t run = socket_->new_run();
    std::memcpy(memory, &run, sizeof run);
    Request request{.kind = kReset, .law = index_, .run = run};
    Numbers numbers{request};
    numbers.add(config.period);
    numbers.add(config.lag);
    numbers.add(config.damping.matrix().data(), 9);  // symmetric: by rows is by columns
    numbers.add(config.rotational_damping.matrix().data(), 9);
    numbers.add(config.damping.least());
    numbers.add(config.rotational_damping.least());
    numbers.add(config.max_force);
    numbers.add(config.max_torque);
    numbers.add(config.rotation ? 1.0 : 0.0);
    socket_->ask(request);
  }
  Command step(std::byte* memory, const BoundingStep& s) override {
    Request request = request_of(kStep, memory);
    Numbers numbers{request};
    numbers.add(s.displacement.data(), 3);
    numbers.add(s.rotation.data(), 3);
    numbers.add(s.hold_time);
    numbers.add(s.command);
    numbers.add(s.local ? 1.0 : 0.0);
    const std::array<double, 9> rendered = socket_->ask(request);
    return {Vec3(rendered.data()), Vec3(rendered.data() + 3), Vec3(rendered.data() + 6)};
  }
  void set_held(std::byte* memory, const Command& held) override {
    Request request = request_of(kHeld, memory);
    Numbers numbers{request};
    numbers.add(held);
    socket_->tell(request);
  }

 private:
  Request request_of(std::uint32_t kind, const std::byte* memory) const {
    Request request{.kind = kind, .law = index_};
    std::memcpy(&request.run, memory, sizeof request.run);
    return request;
  }

  std::shared_ptr<LawSocket> socket_;
  std::uint32_t index_;
};

/// The promise of a coupling is of a law that moves the probe, and these laws do not.
Promise told_promise(std::uint32_t number) {
  if (number > static_cast<std::uint32_t>(Promise::own_sum) ||
      number == static_cast<std::uint32_t>(Promise::coupling))
    throw std::runtime_error("the process that has the law sent no description of it");
  return static_cast<Promise>(number);
}

}  // namespace

void add_socket_laws(int socket, int count) {
  const auto shared = std::make_shared<LawSocket>(socket);
  for (int i = 0; i < count; ++i) {
    Description told;
    shared->receive(&told, sizeof told);
    const auto kept = [&](int fault) { return (static_cast<int>(told.kept_despite) & fault) != 0; };
    const OwnLawEntry entry{.name = shared->receive_text(told.name_size),
                            .promise = told_promise(told.promise),
                            .kept_despite = {.overlong_holds = kept(FELTWIRE_KEPT_OVERLONG_HOLDS),
                                             .reductions = kept(FELTWIRE_KEPT_REDUCTIONS),
                                             .unknown_inputs = kept(FELTWIRE_KEPT_UNKNOWN_INPUTS)},
                            .admits_reduction = told.admits_reduction != 0};
    add_own_law(entry, std::make_unique<SocketLaw>(shared, static_cast<std::uint32_t>(i)));
  }
}

}  // namespace feltwire
