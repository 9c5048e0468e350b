#pragma once
// Bounding laws of the process that started this one, such as Python. It answers on a socket.
//
// All numbers are little-endian. The other process first sends for each law, in this order,
//   u32 promise   u32 kept_despite   u32 admits_reduction   u32 size of the name   the name
// with the numbers of feltwire_law_v1.h. It then answers requests of 216 bytes,
//   u32 kind   u32 index of the law   u64 number of the run   25 doubles
// kind 1 begins a run: period, lag, damping (9), rotational damping (9), least damping of both,
//   largest force, largest torque, 1 if there is torque
// kind 2 is a step: displacement (3), rotation (3), hold time, elastic (3), frictional (3) and
//   torque (3) of the command, 1 if it is local
// kind 3 tells the force that was held: elastic (3), frictional (3), torque (3). It has no answer
// An answer has 80 bytes,
//   u32 0, or 1 for an error   u32 size of a text   elastic (3), frictional (3), torque (3)
// and after them the text of the error.

namespace feltwire {

/// Adds `count` laws that the process at the other end of the open socket computes. Throws
/// std::runtime_error if it sends something else.
void add_socket_laws(int socket, int count);

}  // namespace feltwire
