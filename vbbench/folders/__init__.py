"""Files and folders that are there whole or not at all, whatever stops the command that writes them."""
