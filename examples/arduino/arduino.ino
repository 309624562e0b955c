// Two motors, a servo and a light, driven by voz: the other end of `voz new cart --type serial`.
//
// voz writes `v 0.10 0.00` ten times a second (m/s ahead, rad/s to the left), and `c wave` when the
// command `wave` is obeyed. An H bridge (L298N, TB6612) drives the motors; give it a battery of its
// own, and put the robot on a box, with its wheels in the air, before the first try.

#include <Servo.h>
#include <stdlib.h>
#include <string.h>

// Your wiring: speed (a pin with ~ on the board), ahead, back.
struct Wheel { int speed, ahead, back; };
const Wheel LEFT = {5, 7, 8}, RIGHT = {6, 11, 12};
const int SERVO = 9, LIGHT = 13;

const float TRACK = 0.15;    // between the wheels, m
const float FASTEST = 0.5;   // a wheel at full power, m/s: measure yours
const unsigned long PATIENCE = 500;  // without a line, ms

Servo arm;
char line[32];
unsigned int length = 0;
unsigned long heard = 0;

void turn(const Wheel &wheel, float velocity) {
  digitalWrite(wheel.ahead, velocity > 0);
  digitalWrite(wheel.back, velocity < 0);
  analogWrite(wheel.speed, constrain(fabs(velocity) / FASTEST, 0, 1) * 255);
}

void drive(float ahead, float left) {
  turn(LEFT, ahead - left * TRACK / 2);
  turn(RIGHT, ahead + left * TRACK / 2);
}

// What your own commands do.
void obey(const char *command) {
  if (!strcmp(command, "wave")) arm.write(arm.read() == 90 ? 0 : 90);
  if (!strcmp(command, "light on")) digitalWrite(LIGHT, HIGH);
  if (!strcmp(command, "light off")) digitalWrite(LIGHT, LOW);
}

void take(char *line) {
  if (!strncmp(line, "c ", 2)) obey(line + 2);
  if (strncmp(line, "v ", 2)) return;
  char *between, *end;
  float ahead = strtod(line + 2, &between), left = strtod(between, &end);
  if (between == line + 2 || end == between || *end) return;  // cut off on its way
  drive(ahead, left);
  heard = millis();
}

void setup() {
  Serial.begin(115200);
  for (const Wheel &wheel : {LEFT, RIGHT}) {
    pinMode(wheel.speed, OUTPUT);
    pinMode(wheel.ahead, OUTPUT);
    pinMode(wheel.back, OUTPUT);
  }
  pinMode(LIGHT, OUTPUT);
  arm.attach(SERVO);
  drive(0, 0);
}

void loop() {
  while (Serial.available()) {
    char sign = Serial.read();
    if (sign != '\n') {
      if (length < sizeof line - 1) line[length] = sign;
      length++;
    } else {
      if (length < sizeof line) {
        line[length] = 0;
        take(line);
      }
      length = 0;
    }
  }
  if (millis() - heard > PATIENCE) drive(0, 0);  // the cable is out, or the computer hangs
}
