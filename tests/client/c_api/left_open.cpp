// A program that opens all handles of the C interface, closes none of them, and ends.
// Arguments: HOST:PORT FINGERPRINT TOKEN_FILE RECORDING. Exit status 0: all was opened.

#include <array>
#include <cstdio>

#include "client/c_api/feltwire.h"

int main(int count, char** words) {
  constexpr int kWords = 5;
  if (count != kWords) return 2;
  const auto set_access = [&](auto& options) {
    options.server = words[1];
    options.fingerprint = words[2];
    options.token_file = words[3];
  };
  std::array<const char*, 2> more{"--let-go-after", "1"};

  fw_hand_options of_hand;
  fw_hand_options_default(&of_hand, sizeof of_hand);
  set_access(of_hand);
  of_hand.scene = "floor";
  of_hand.more = more.data();
  of_hand.more_count = more.size();
  fw_observer_options of_observer;
  fw_observer_options_default(&of_observer, sizeof of_observer);
  set_access(of_observer);
  of_observer.scene = "floor";
  fw_recorder_options of_recorder;
  fw_recorder_options_default(&of_recorder, sizeof of_recorder);
  of_recorder.file = words[4];

  // Static, so that a search for leaks finds the handles.
  static fw_hand* hand = nullptr;
  static fw_observer* observer = nullptr;
  static fw_recorder* recorder = nullptr;
  if (fw_hand_open(&of_hand, &hand) != FW_OK ||
      fw_recorder_open(hand, &of_recorder, &recorder) != FW_OK ||
      fw_observer_open(&of_observer, &observer) != FW_OK) {
    std::fprintf(stderr, "%s\n", fw_last_error());
    return 1;
  }
  return 0;
}
