/* Prints how long the calls take that never wait, of an observer and of hands: observer_cost
 * HOST:PORT FINGERPRINT_FILE TOKEN_FILE SCENE (observer_cost.py). */
#define _POSIX_C_SOURCE 199309L

#include <stdio.h>
#include <time.h>

#include "feltwire.h"

enum { kRounds = 200, kCalls = 1000, kMost = 64 };

static fw_observer* observer;
static fw_hand *hand, *moved, *in_world; /* simulated, moved by this program, in its physics */
static fw_seen_hand hands[kMost];
static fw_scene_state state;
static fw_tick tick;
static fw_pose pose;
static fw_patch patch;
static fw_wrench wrench;
static uint32_t count;

static void observer_latest(void) { fw_observer_latest(observer, &state, sizeof state); }
static void observer_hands(void) {
  fw_observer_hands(observer, hands, sizeof hands[0], kMost, &count);
}
static void hand_latest(void) { fw_hand_latest(hand, &tick, sizeof tick); }
static void hand_exchange(void) { fw_hand_exchange(moved, &pose, &tick, sizeof tick); }
static void hand_touch(void) {
  fw_hand_touch(in_world, wrench.time, 0.05, &patch, sizeof patch, 1);
}
static void hand_push(void) { fw_hand_push(in_world, &wrench); }

static const struct {
  const char* name;
  void (*call)(void);
} kMeasured[] = {{"fw_observer_latest", observer_latest}, {"fw_observer_hands", observer_hands},
                 {"fw_hand_latest", hand_latest},         {"fw_hand_exchange", hand_exchange},
                 {"fw_hand_touch", hand_touch},           {"fw_hand_push", hand_push}};

static double now(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static int failed(const char* what) {
  fprintf(stderr, "observer_cost: %s: %s\n", what, fw_last_error());
  return 1;
}

static int open_all(char** argv) {
  static const char* more[] = {"--flight-recorder", "off", "--let-go-after", "1"};
  fw_observer_options options;
  fw_hand_options of_hand;
  fw_world_options of_world;
  fw_observer_options_default(&options, sizeof options);
  fw_hand_options_default(&of_hand, sizeof of_hand);
  fw_world_options_default(&of_world, sizeof of_world);
  options.server = of_hand.server = argv[1];
  options.fingerprint_file = of_hand.fingerprint_file = argv[2];
  options.token_file = of_hand.token_file = argv[3];
  options.scene = of_hand.scene = argv[4];
  of_hand.more = of_world.more = more;
  of_hand.more_count = of_world.more_count = 4;
  if (fw_observer_open(&options, &observer) != FW_OK) return failed("observer");
  if (fw_hand_open(&of_hand, &hand) != FW_OK) return failed("hand");
  of_hand.device = "caller";
  if (fw_hand_open(&of_hand, &moved) != FW_OK) return failed("hand of the program");
  of_world.stiffness = 1000.0;
  if (fw_hand_open_world(&of_world, &in_world) != FW_OK) return failed("world");
  fw_pose_default(&pose, sizeof pose);
  fw_patch_default(&patch, sizeof patch);
  fw_wrench_default(&wrench, sizeof wrench);
  wrench.stiffness = 1000.0;
  fw_observer_wait(observer, 30, 20.0);
  return 0;
}

int main(int argc, char** argv) {
  double best[sizeof kMeasured / sizeof kMeasured[0]];
  unsigned which;
  int round, i;
  if (argc != 5) return 2;
  if (open_all(argv) != 0) return 1;
  for (round = 0; round < kRounds; ++round) {
    for (which = 0; which < sizeof kMeasured / sizeof kMeasured[0]; ++which) {
      double begin, took;
      fw_hand_latest(in_world, &tick, sizeof tick);
      wrench.time = tick.time;
      begin = now();
      for (i = 0; i < kCalls; ++i) kMeasured[which].call();
      took = (now() - begin) / kCalls;
      if (round == 0 || took < best[which]) best[which] = took;
    }
  }
  for (which = 0; which < sizeof kMeasured / sizeof kMeasured[0]; ++which)
    printf("C: %s() %.0f ns\n", kMeasured[which].name, 1e9 * best[which]);
  printf("C: %u hands were seen\n", (unsigned)count);
  fw_hand_close(hand); /* whose run this loop may have disturbed */
  fw_hand_close(moved);
  fw_hand_close(in_world);
  return fw_observer_close(observer) == FW_OK ? 0 : failed("observer");
}
