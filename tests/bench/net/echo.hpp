#pragma once
// The cost of a server that only sends every datagram back to its sender.

namespace feltwire::netbench {

enum class EchoKind {
  blocking,  // recvmmsg waits for the first datagram of a batch
  waiting,   // poll waits, recvmmsg takes what there is
  spinning   // recvmmsg again and again
};

/// For ever, on a socket of the caller's.
[[noreturn]] void echo(int socket, EchoKind kind);

}  // namespace feltwire::netbench
