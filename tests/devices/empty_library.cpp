// A shared library of somebody else.
extern "C" int answer() { return 42; }
