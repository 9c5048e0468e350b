// A shared library without the maker's functions.
extern "C" int answer() { return 42; }
