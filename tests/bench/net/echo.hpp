#pragma once
// The cost of a server that only returns every datagram to its sender.

namespace feltwire::netbench {

enum class EchoKind {
  blocking,  // recvmmsg waits for the first datagram of a batch
  waiting,   // poll waits, recvmmsg takes what has arrived
  spinning   // recvmmsg repeatedly
};

/// Runs for ever on the caller's socket.
[[noreturn]] void echo(int socket, EchoKind kind);

}  // namespace feltwire::netbench
