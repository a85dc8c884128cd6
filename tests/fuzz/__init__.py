"""Every kind of file that vbbench reads, mutated: it is read or refused in one clear line, and nothing else happens."""
