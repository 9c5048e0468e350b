#include "server/scene/session_end.hpp"

namespace feltwire {

std::string_view text(SessionEnd how) {
  switch (how) {
    case SessionEnd::goodbye:
      return "the client said goodbye";
    case SessionEnd::asked:
      return "a LeaveRequest ended it";
    case SessionEnd::silent:
      return "nothing came from the client for the silence timeout";
    case SessionEnd::flooded:
      return "the client sent far more samples than it may";
    case SessionEnd::forged:
      return "too many datagrams with its number were forged";
    case SessionEnd::disturbing:
      return "its hand broke the simulation of what moves again and again";
    case SessionEnd::evicted:
      return "it was evicted";
    case SessionEnd::tool_gone:
      return "the reloaded scene does not have its tool";
    case SessionEnd::failed:
      return "the server failed in its scene";
    case SessionEnd::shut_down:
      return "the server shut down";
  }
  return "";
}

}  // namespace feltwire
