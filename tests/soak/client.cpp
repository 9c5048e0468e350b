#include "tests/soak/client.hpp"

#include <array>
#include <utility>

#include "protocol/wire/guard.hpp"

namespace feltwire::soak {
namespace {

constexpr std::chrono::milliseconds kJoinTimeout{5000};
// [s] life of a client and pause between two lives
constexpr double kShortestLife = 0.3, kLongestLife = 4.0, kLongestPause = 0.5;
constexpr double kMeanStay = 1.0;  // [s] mean time at a port
constexpr double kDiesWithoutWord = 0.4;
constexpr int kGoodbyes = 3;
constexpr Nanoseconds kGrace = std::chrono::seconds(1);
constexpr unsigned kAnyKind = ~0u;
constexpr std::size_t kRemembered = 256;  // number of samples with a measured round trip

/// Returns the next datagram that has already arrived, or nothing.
Bytes take(const test::RawSocket& socket, std::span<std::uint8_t> buffer) {
  const auto size = ::recv(socket.descriptor(), buffer.data(), buffer.size(), MSG_DONTWAIT);
  return {buffer.data(), size > 0 ? static_cast<std::size_t>(size) : 0};
}

std::unique_ptr<test::RawSocket> open_port(std::uint16_t server) {
  return std::make_unique<test::RawSocket>(SOCK_DGRAM, server);
}

/// Returns a hand that moves at the scene's start position.
HandTask task(const control::JoinAccepted& accepted, std::uint64_t seed) {
  HandTask task;
  task.path = seed % 2 == 0 ? HandPath::slide : HandPath::taps;
  task.center = accepted.start_position;
  set_normal(task, accepted.start_normal);
  task.lead_in = 0.1;
  task.frequency = 2.0;
  task.tremor = 2e-4;
  task.seed = seed;
  return task;
}

std::uint16_t scene_port(const Joined& joined) {
  return ntohs(reinterpret_cast<const sockaddr_in&>(joined.datagrams.storage).sin_port);
}

// Only this function makes a datagram session from an accepted join.
DatagramSession make_datagram_session(const Joined& joined) {
  return {joined.accepted.session, joined.keys, joined.accepted.parameters, false};
}

}  // namespace

struct Client::Life {
  std::uint64_t session;
  std::uint16_t port;  // port of the scene
  DatagramSession datagrams;
  SimulatedDevice device;
  Servo servo;
  std::unique_ptr<test::RawSocket> socket;
  Nanoseconds clock{0};  // the client's clock: a period per tick, even on a slow machine
  Nanoseconds end{0}, next_move{0};             // on the machine's clock
  std::array<Nanoseconds, kRemembered> sent{};  // on the machine's clock, by sample
  Reply reply;

  Life(const Joined& joined, const HandTask& task)
      : session(joined.accepted.session),
        port(scene_port(joined)),
        datagrams(make_datagram_session(joined)),
        device({.spec = builtin_device("simulated"), .hand = {}, .task = task}),
        servo(device.spec(), joined.accepted.parameters),
        socket(open_port(port)) {}
};

Client::Client(const ClientOptions& options, Account& account)
    : options_(options), account_(&account) {}
Client::~Client() = default;
Client::Client(Client&&) noexcept = default;

SessionParameters Client::parameters() {
  constexpr std::array kSides = {BoundingSide::client, BoundingSide::both, BoundingSide::server};
  SessionParameters p;
  p.servo_period = seconds(options_.period);
  p.side = kSides[static_cast<std::size_t>(draw(0.0, kSides.size()))];
  p.redundancy = static_cast<int>(draw(0.0, 4.0));
  p.local_model = p.side != BoundingSide::server && draw() < 0.3;
  if (draw() < 0.3) p.force_deadband = 0.05;
  return p;
}

void Client::be_born(Nanoseconds now) {
  try {
    const Joined joined =
        join(options_.server, {"soak", options_.scene, builtin_device("simulated"), parameters()},
             kJoinTimeout);
    life_ = std::make_unique<Life>(joined, task(joined.accepted, draws_));
  } catch (const std::runtime_error& refused) {
    ++account_->refused;
    account_->last_refusal = refused.what();
    next_birth_ = now + from_seconds(draw(0.0, kLongestPause));
    return;
  }
  ++account_->lives;
  life_->end = now + from_seconds(draw(kShortestLife, kLongestLife));
  life_->next_move = now + from_seconds(draw(0.0, 2.0 * kMeanStay));
}

void Client::keep(std::unique_ptr<test::RawSocket> socket, Nanoseconds now) {
  // The client keeps the port until the server has sent its last datagram to this port.
  old_ports_.push_back(
      {std::move(socket), life_->session, now + 2 * options_.silence_timeout + kGrace});
}

void Client::move_house(Nanoseconds now) {
  keep(std::exchange(life_->socket, open_port(life_->port)), now);
  life_->next_move = now + from_seconds(draw(0.0, 2.0 * kMeanStay));
  ++account_->roamed;
}

void Client::die(Nanoseconds now) {
  account_->violations += life_->servo.port().violations();
  account_->samples += life_->servo.statistics().samples;
  if (draw() < kDiesWithoutWord) {
    ++account_->died;
  } else {
    for (int i = 0; i < kGoodbyes; ++i) life_->socket->send(life_->datagrams.goodbye());
    ++account_->left;
  }
  keep(std::move(life_->socket), now);
  life_.reset();
  next_birth_ = now + from_seconds(draw(0.0, kLongestPause));
}

void Client::receive(Nanoseconds now) {
  std::array<std::uint8_t, kMaxDatagram + 1> buffer;
  GoodbyeReason reason{};
  for (Bytes bytes = take(*life_->socket, buffer); !bytes.empty();
       bytes = take(*life_->socket, buffer)) {
    if (guard(bytes, kAnyKind).header.session != life_->session) ++account_->misaddressed;
    switch (life_->datagrams.take(bytes, life_->reply, reason)) {
      case DatagramSession::Arrival::reply:
        ++account_->replies;
        if (life_->reply.command.elastic.squaredNorm() > 0.0) ++account_->with_force;
        account_->round_trip.record(
            (now - life_->sent[life_->reply.sample_index % kRemembered]).count());
        life_->servo.take(life_->reply, life_->clock);
        break;
      case DatagramSession::Arrival::goodbye:
        ++account_->sent_away;
        break;
      case DatagramSession::Arrival::dropped:
        ++account_->dropped;
        break;
    }
  }
}

void Client::tick(Nanoseconds now) {
  if (life_ == nullptr) {
    if (now >= next_birth_) be_born(now);
    return;
  }
  life_->clock += options_.period;
  receive(now);
  ++account_->ticks;
  const Sample* sample = life_->servo.tick(life_->device, life_->clock);
  const Command& held = life_->servo.held();
  constexpr double kRounding = 1e-9;
  if (!held.finite() || held.force().norm() > life_->device.spec().max_force * (1.0 + kRounding))
    ++account_->faulty_forces;
  if (sample != nullptr) {
    const Bytes datagram = life_->datagrams.pack(*sample);
    if (!datagram.empty()) {
      life_->socket->send(datagram);
      life_->sent[sample->index % kRemembered] = now;
      life_->servo.sent();
    }
  }
  if (now >= life_->end) return die(now);
  if (now >= life_->next_move) move_house(now);
}

void Client::end(Nanoseconds now) {
  if (life_ != nullptr) die(now);
}

void Client::watch_old_ports(Nanoseconds now) {
  std::array<std::uint8_t, kMaxDatagram + 1> buffer;
  for (const OldPort& port : old_ports_)
    for (Bytes bytes = take(*port.socket, buffer); !bytes.empty();
         bytes = take(*port.socket, buffer))
      if (guard(bytes, kAnyKind).header.session != port.session) ++account_->misaddressed;
  std::erase_if(old_ports_, [now](const OldPort& port) { return now >= port.until; });
}

}  // namespace feltwire::soak
