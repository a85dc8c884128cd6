"""A fixed camera high above a crowd, and the recording of people's heads that annotators would make of its pictures."""
