// Takes arbitrary bytes from the serial port of a 2-dof open board. The result must be no reply, or
// possible arm angles and a tool that the links reach.

#include "client/drivers/haply/hapi_board.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire;
  using namespace feltwire::fuzz;
  Input input(data, size);
  hapi::Reply reply;
  std::size_t given = 0;
  while (!input.empty()) {
    const std::uint8_t piece = input.byte();
    const Bytes bytes = input.bytes(1U + piece % 16U);
    reply.add(bytes);
    given += bytes.size();
    require(reply.size() == given, "every byte is counted");
    if (const auto angles = reply.angles()) {
      require(given == hapi::kAngleReplyBytes && !reply.garbled(given), "an answer is whole");
      require(angles->allFinite() && angles->norm() < 20.0, "angles are possible");
      if (const auto tool = hapi::tool_point(*angles)) {
        require(tool->position.allFinite() && tool->position.norm() < 0.15, "links have an end");
        require(tool->jacobian.allFinite(), "and a jacobian");
        require(hapi::torque_of(*tool, {1.0, -1.0}).allFinite(), "forces have torques");
      }
    }
    if (reply.garbled(hapi::kAngleReplyBytes) || given >= hapi::kAngleReplyBytes) {
      require(reply.garbled(hapi::kAngleReplyBytes) || given == hapi::kAngleReplyBytes,
              "more than an answer is none");
      reply.clear();
      given = 0;
    }
  }
  return 0;
}
