"""The data that carlette reads from an OpenDRIVE map."""
