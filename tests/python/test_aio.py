#!/usr/bin/env python3
"""feltwire.aio: hands in an event loop that never waits for them."""
import asyncio
import pathlib
import tempfile
import threading
import unittest

from support import LONGEST, PATIENT, SOURCE
import feltwire
import feltwire.recorder


class AsyncHands(unittest.IsolatedAsyncioTestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = feltwire.serve(SOURCE / "scenes/plane.json")

    @classmethod
    def tearDownClass(cls):
        cls.server.close()

    def join(self, **options):
        return feltwire.aio.join(self.server.address, self.server.scenes[0], fingerprint_file=self.server.fingerprint_file,
                                 token_file=self.server.token_file, **PATIENT, **options)

    async def test_every_tick_comes_once_and_no_thread_comes_with_it(self):
        async with self.join(device="simulated:path=press", duration=1.5) as hand:
            threads = threading.active_count()
            numbers = [int(tick["number"] if hasattr(tick, "dtype") else tick.number) async for tick in hand]
            self.assertTrue(await hand.wait(LONGEST))
            self.assertEqual(threading.active_count(), threads)
        self.assertEqual(numbers, list(range(1, len(numbers) + 1)))
        self.assertGreater(len(numbers), 100)

    async def test_two_hands_in_one_loop(self):
        async def largest(hand):
            return max([max(float(one["force"][2] if hasattr(one, "dtype") else one.force[2]) for one in batch)
                        async for batch in hand.batches(0.05)])

        async with self.join(device="simulated:path=press", duration=1.5) as one, self.join(device="simulated:path=taps", duration=1.5) as other:
            self.assertFalse(await one.wait(0.0))
            for force in await asyncio.gather(largest(one), largest(other)):
                self.assertGreater(force, 0.2)

    async def test_a_program_moves_a_hand(self):
        async with self.join(device="caller:await_still=0", stale_after=0.2, hold_time=1) as hand:
            start, normal = hand.session.start_position, hand.session.start_normal

            async def touch():
                height = 0.004
                while True:
                    given = hand.exchange([start[i] + height * normal[i] for i in range(3)])
                    if given is not None and sum(given[0][i] * normal[i] for i in range(3)) > 0.3:
                        return
                    height = max(height - 2e-5, -0.002)
                    await asyncio.sleep(0.001)

            await asyncio.wait_for(touch(), LONGEST)
            self.assertEqual(hand.why_no_force(), "")
            hand.messages()
            hand.stop()
            self.assertTrue(await hand.wait(LONGEST))

    async def test_the_loop_goes_on_while_a_hand_joins_and_closes(self):
        turns, done = 0, False

        async def count():
            nonlocal turns
            while not done:
                turns += 1
                await asyncio.sleep(0)

        counting = asyncio.ensure_future(count())
        hand = await self.join()
        before = turns
        self.assertGreater(before, 1)
        await hand.close()
        self.assertGreater(turns, before)
        done = True
        await counting
        with self.assertRaisesRegex(ValueError, "closed"):
            await hand.wait()
        await hand.close()

    async def test_errors_are_those_of_the_blocking_calls(self):
        with self.assertRaisesRegex(TypeError, "feltwire.aio.join"):
            async with self.server.join(**PATIENT):
                pass
        with self.assertRaisesRegex(ValueError, "pth"):
            await self.join(pth="press")
        with self.assertRaises(feltwire.Refused):
            async with feltwire.aio.join(self.server.address, "no_such_scene", fingerprint_file=self.server.fingerprint_file,
                                         token_file=self.server.token_file):
                pass

    async def test_a_hand_of_the_program_has_a_gripper_too(self):
        async with self.join(device="caller") as hand:
            self.assertIsNotNone(hand.exchange((0.0, 0.0, 0.1), deadman=True, gripper=0.04))
            self.assertEqual(hand.hand._pose.gripper, 0.04)

    async def test_a_recording_of_a_hand(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "hand.mcap"
            async with self.join(device="simulated:path=press") as hand:
                async with hand.record(file) as recorder:
                    while recorder.state().ticks < 100:
                        await asyncio.sleep(0.01)
                    await recorder.mark("half")
                    with self.assertRaisesRegex(ValueError, "recorded already"):
                        await hand.record(file.with_name("second.mcap"))
                self.assertGreater(len(hand.ticks()), 0)
                again = await hand.record(file, replace=True)
                await again.close()
                await again.close()
                with self.assertRaisesRegex(ValueError, "recorder is closed"):
                    await again.mark("late")

    async def test_a_hand_has_all_that_the_blocking_one_has(self):
        def public(kind):
            return {name for name in dir(kind) if not name.startswith("_") and name not in ("NAME", "AIO", "renew_locks")}

        for blocking, twin in ((feltwire.Hand, feltwire.aio.Hand), (feltwire.Follower, feltwire.aio.Follower),
                               (feltwire.recorder.Recorder, feltwire.aio.Recorder), (feltwire.Observer, feltwire.aio.Observer),
                               (feltwire.Admin, feltwire.aio.Admin)):
            self.assertEqual(public(blocking) - public(twin), set(), twin)

    async def test_an_observer_and_an_admin_in_one_loop(self):
        def seen(hands, field):
            return hands[0][field] if hasattr(hands, "dtype") else getattr(hands[0], field)

        trusted = {"fingerprint_file": self.server.fingerprint_file}
        async with self.join(device="simulated:path=press", name="anna"), \
                feltwire.aio.observe(self.server.address, "plane", token_file=self.server.token_file, **trusted) as observer, \
                feltwire.aio.admin(self.server.address, token_file=self.server._token("admin", "*"), **trusted) as admin:
            numbers = []

            async def watch():
                async for state in observer:
                    numbers.append(state.number)
                    hands = observer.hands()
                    if len(hands) and len(numbers) > 5:
                        return int(seen(hands, "number"))

            number = await asyncio.wait_for(watch(), LONGEST)
            self.assertEqual(numbers, sorted(set(numbers)))
            sessions = {session["number"]: session["client"] for session in await admin.sessions()}
            self.assertEqual(len(sessions), 2, sessions)
            self.assertIn(number, sessions)
            self.assertTrue(await observer.wait(LONGEST))
            self.assertFalse(await observer.wait(0.0, after=2**60))
            with self.assertRaisesRegex(feltwire.Refused, "object"):
                await admin.set(object="no_such_object", stiffness=500)
            self.assertEqual((await admin.scenes())[0]["scene"], "plane")
            await admin.close()
            with self.assertRaisesRegex(ValueError, "admin is closed"):
                await admin.stats()
        with self.assertRaisesRegex(ValueError, "observer is closed"):
            await observer.wait()
        with self.assertRaisesRegex(TypeError, "feltwire.aio.observe"):
            async with self.server.observe():
                pass

    async def test_a_join_that_is_cancelled_closes_its_hand(self):
        joining = asyncio.ensure_future(self.join()._run())
        await asyncio.sleep(0)
        joining.cancel()
        with self.assertRaises(asyncio.CancelledError):
            await joining
        async with self.join() as hand:  # the server still takes hands
            self.assertFalse(await hand.wait(0.0))


if __name__ == "__main__":
    unittest.main()
