// As much of Arduino as the sketch of examples/arduino needs, with the clock in the test's hands.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <iostream>
#include <map>
#include <string>

enum { LOW, HIGH, OUTPUT };
#define constrain(x, low, high) std::min<double>(std::max<double>(x, low), high)

std::map<int, int> pins;
unsigned long now = 0;

void pinMode(int, int) {}
void digitalWrite(int pin, int level) { pins[pin] = level; }
void analogWrite(int pin, int level) { pins[pin] = level; }
unsigned long millis() { return now; }

struct {
  std::deque<char> waiting;
  void begin(long) {}
  int available() { return waiting.size(); }
  int read() {
    char first = waiting.front();
    waiting.pop_front();
    return first;
  }
} Serial;
