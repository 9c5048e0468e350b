/* Prints how long the getters of an observer take: observer_cost HOST:PORT FINGERPRINT_FILE
 * TOKEN_FILE SCENE (observer_cost.py). */
#define _POSIX_C_SOURCE 199309L

#include <stdio.h>
#include <time.h>

#include "feltwire.h"

enum { kRounds = 50, kCalls = 10000, kMost = 64 };

static double now(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

int main(int argc, char** argv) {
  static fw_seen_hand hands[kMost];
  fw_observer_options options;
  fw_observer* observer;
  fw_scene_state state;
  uint32_t count = 0;
  double latest = 1.0, list = 1.0;
  int round, i;
  if (argc != 5) return 2;
  fw_observer_options_default(&options, sizeof options);
  options.server = argv[1];
  options.fingerprint_file = argv[2];
  options.token_file = argv[3];
  options.scene = argv[4];
  if (fw_observer_open(&options, &observer) != FW_OK) {
    fprintf(stderr, "observer_cost: %s\n", fw_last_error());
    return 1;
  }
  fw_observer_wait(observer, 30, 20.0);
  for (round = 0; round < kRounds; ++round) {
    double begin = now(), end;
    for (i = 0; i < kCalls; ++i) fw_observer_latest(observer, &state, sizeof state);
    end = now();
    if (end - begin < latest * kCalls) latest = (end - begin) / kCalls;
    begin = now();
    for (i = 0; i < kCalls; ++i) fw_observer_hands(observer, hands, sizeof hands[0], kMost, &count);
    end = now();
    if (end - begin < list * kCalls) list = (end - begin) / kCalls;
  }
  printf("C: fw_observer_latest() %.0f ns, fw_observer_hands() %.0f ns for %u hands\n",
         1e9 * latest, 1e9 * list, (unsigned)count);
  return fw_observer_close(observer) == FW_OK ? 0 : 1;
}
