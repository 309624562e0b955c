"""From an utterance to motion: the robot's command rules and the safety behind them."""
