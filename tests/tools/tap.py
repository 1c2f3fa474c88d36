"""TAP from Python, as tap.sh for the shell: say(good, text) for each check, finish() at the end."""
import sys

count = failed = 0


def say(good, text):
    global count, failed
    count += 1
    failed += not good
    print(f"{'ok' if good else 'not ok'} {count} - {text}", flush=True)


def finish():
    print(f"1..{count}")
    sys.exit(failed > 0)
