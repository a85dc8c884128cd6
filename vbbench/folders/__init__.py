"""Files and folders that are written completely or not at all, whatever stops the command that writes them."""
