"""What each person of a scene sees: a camera carried along, and the people in its picture."""
