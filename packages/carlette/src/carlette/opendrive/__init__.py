"""What carlette reads from an OpenDRIVE map."""
