#pragma once
// What a server costs that does nothing: every datagram goes back to where it came from.

namespace feltwire::netbench {

enum class EchoKind {
  blocking,  // recvmmsg waits for the first datagram of a batch
  waiting,   // poll waits, recvmmsg takes what there is
  spinning   // recvmmsg again and again
};

/// For ever, on a socket of the caller's.
[[noreturn]] void echo(int socket, EchoKind kind);

}  // namespace feltwire::netbench
