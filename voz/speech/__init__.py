"""What the robot says: replies rendered by festival and played beside the control cycle."""
