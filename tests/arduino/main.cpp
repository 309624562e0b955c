// Reads what comes over the cable: a line for each 100 ms, in which `+` lets them pass without one.
// Writes after each how the pins stand: speed and direction of both wheels, servo, light.
#include "Arduino.h"

#include "arduino.ino"

int signed_speed(const Wheel &wheel) { return pins[wheel.speed] * (pins[wheel.ahead] - pins[wheel.back]); }

int main() {
  setup();
  for (std::string text; std::getline(std::cin, text); now += 100) {
    if (text != "+")
      for (char sign : text + "\n") Serial.waiting.push_back(sign);
    loop();
    std::printf("%d %d %d %d\n", signed_speed(LEFT), signed_speed(RIGHT), pins[SERVO], pins[LIGHT]);
  }
}
