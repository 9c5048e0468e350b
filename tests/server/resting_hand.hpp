#pragma once
// A resting hand over a real socket.

#include <gtest/gtest.h>

#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"
#include "tests/server/raw_socket.hpp"

namespace feltwire::test {

/// A hand that rests 1 mm below the floor, over real datagrams.
class RestingHand {
 public:
  /// The client's connection must stay open.
  explicit RestingHand(ControlClient& client, const SessionParameters& parameters = {})
      : joined_(client.join(join_request(parameters))),
        socket_(SOCK_DGRAM, joined_.udp_port),
        encoder_(Way::up, joined_.keys) {}
  /// [N] the z component of the scene's answer.
  double force() {
    SampleBatch batch = hand_batch(++index_);
    batch.samples[0].pose.position = {0, 0, -0.001};
    socket_.send(encoder_.samples(joined_.accepted.session, index_, batch));
    Reply reply;
    EXPECT_EQ(decode(opened(socket_.receive(), Way::down, joined_.keys), reply), DropReason::none);
    return reply.command.elastic.z();
  }
  std::uint64_t session() const { return joined_.accepted.session; }

 private:
  JoinedBy joined_;
  RawSocket socket_;
  SealedEncoder encoder_;
  std::uint64_t index_ = 0;
};

}  // namespace feltwire::test
